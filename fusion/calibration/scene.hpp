#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/sweep.hpp"
#include "fusion/calibration/feature.hpp"
#include "fusion/calibration/surface_normals.hpp"
#include "fusion/features/discontinuity.hpp"
#include "fusion/features/plane.hpp"
#include "fusion/features/ring_directions.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::calibration {

/// m; returns farther away are not compared with images.
inline constexpr double kMaxSceneRange = 100;

/// Features that are computed of a sweep and an image.
struct SceneOptions {
  /// Features to compute: relative reflectivity and discontinuity.
  PerLidarFeature<bool> lidar{false, true, false, true};
  PerImageFeature<bool> image{false, true, true};  ///< features to compute: local grey, ring edge
  features::RingDirections rings;                  ///< of this camera's images, for the ring edge
  features::DiscontinuityOptions discontinuity;    ///< of depth edges
  NormalOptions normals;                           ///< of surfaces
  /// Grey and edges by rank within the image, so that exposure does not matter. False: values
  /// divided by 255.
  bool equalize = true;
  double min_range = 1.5;             ///< m; nearer returns (the vehicle itself) are dropped
  double max_range = kMaxSceneRange;  ///< m

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

class SceneImages;

/// Features of a sweep and of the image taken with it, which calibration compares.
struct Scene {
  std::string name;            ///< for reports
  size_t camera = 0;           ///< index of the camera of the rig that took the image
  std::vector<float> x, y, z;  ///< m, lidar frame
  PerLidarFeature<std::vector<float>> lidar;  ///< one value per point; empty where not computed
  PerImageFeature<features::Plane> image;     ///< 0 … 1; empty where not computed, or released
  /// Prepared by `compact_scene`, in place of `image`; null otherwise.
  std::shared_ptr<const SceneImages> blurred;
  /// What `scene_similarity` compares; null: it is computed there.
  std::shared_ptr<const Eigen::VectorXf> signature;
  std::optional<geometry::Vector6> twist;  ///< rad/s, m/s: the lidar's motion in its own frame
                                           ///< when the image was taken, where known

  size_t size() const { return x.size(); }  ///< number of returns
};

/// Computes the features of a kGrey8 or kBgr8 image that `options` name; the other planes stay
/// empty.
PerImageFeature<features::Plane> compute_image_features(const CameraFrame& frame,
                                                        const SceneOptions& options);

/// Computes the features of a sweep, deskewed to the image's exposure, and of the image. Errors: an
/// empty image or sweep, a Bayer mosaic, a sweep without rings where a feature needs them.
Result<Scene> make_scene(const Sweep& sweep, const CameraFrame& frame, const SceneOptions& options);

}  // namespace infuse::calibration
