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

/// A camera of a rig whose cameras are known relative to each other (P 3.4.1); what is estimated is
/// T_head_lidar. A camera alone is its own head.
struct RigCamera {
  geometry::CameraModel model;
  Eigen::Isometry3d T_camera_refcam = Eigen::Isometry3d::Identity();
};

/// Which points take part.
struct VisibilityOptions {
  double min_depth = 1.0;        ///< m along the optical axis
  std::optional<features::OcclusionOptions> occlusion = features::OcclusionOptions{};  ///< none: no
                                                                                       ///< point is hidden
  size_t max_points = 0;  ///< maximum number, of all scenes together, thinned evenly; 0: all

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// The points in view of all scenes, pooled, scene after scene.
struct VisiblePoints {
  /// A scene's part of the arrays: [begin, end).
  struct Block {
    size_t scene = 0;
    size_t begin = 0, end = 0;
  };
  std::vector<Block> blocks;   ///< a scene without a point in view has an empty one
  std::vector<float> x, y, z;  ///< m, lidar frame
  PerLidarFeature<std::vector<float>> lidar;

  size_t size() const { return x.size(); }
};

/// The points that lie in the picture and are not hidden under every one of the poses T_head_lidar.
/// Chosen once a start, so that the set that a measure is asked about does not change while it is
/// maximised: the plug-in estimate rises when points leave the picture, and an optimiser finds that
/// out. Of several poses: the set on which they can be compared.
VisiblePoints select_visible(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                             std::span<const Eigen::Isometry3d> poses,
                             const VisibilityOptions& options);

/// The same under one pose.
VisiblePoints select_visible(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                             const Eigen::Isometry3d& T_head_lidar,
                             const VisibilityOptions& options);

/// The points of blocks that follow one another alone; at least one block.
VisiblePoints select_blocks(const VisiblePoints& points,
                            std::span<const VisiblePoints::Block> blocks);

}  // namespace infuse::calibration
