#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fusion/calibration/scene.hpp"
#include "fusion/features/occlusion_buffer.hpp"
#include "fusion/geometry/camera_model.hpp"

namespace infuse::calibration {

/// Camera of a rig whose cameras are calibrated relative to each other (P 3.4.1); the estimate is
/// T_refcam_lidar. A single camera is its own reference camera.
struct RigCamera {
  geometry::CameraModel model;
  Eigen::Isometry3d T_camera_refcam = Eigen::Isometry3d::Identity();
};

/// Settings of the choice of points.
struct VisibilityOptions {
  double min_depth = 1.0;  ///< m along the optical axis
  /// Occlusion culling; empty: no point is hidden.
  std::optional<features::OcclusionOptions> occlusion = features::OcclusionOptions{};
  size_t max_points = 0;  ///< maximum number, of all scenes together, thinned evenly; 0: all

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Points in view of all scenes, scene after scene.
struct VisiblePoints {
  /// Part of the arrays that belongs to a scene: [begin, end).
  struct Block {
    size_t scene = 0;
    size_t begin = 0, end = 0;
  };
  std::vector<Block> blocks;   ///< one per scene; empty for a scene without a point in view
  std::vector<float> x, y, z;  ///< m, lidar frame
  PerLidarFeature<std::vector<float>> lidar;

  size_t size() const { return x.size(); }
};

/// Selects the points that are in the image and not hidden under every one of the poses
/// T_refcam_lidar. Selected once per ascent, so that the set does not change while a measure is
/// maximised: the plug-in estimate rises as points leave the image. Several poses give the set on
/// which they can be compared.
VisiblePoints select_visible(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                             std::span<const Eigen::Isometry3d> poses,
                             const VisibilityOptions& options);

/// The same under one pose.
VisiblePoints select_visible(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                             const Eigen::Isometry3d& T_refcam_lidar,
                             const VisibilityOptions& options);

/// Returns the points of consecutive blocks alone; at least one block.
VisiblePoints select_blocks(const VisiblePoints& points,
                            std::span<const VisiblePoints::Block> blocks);

}  // namespace infuse::calibration
