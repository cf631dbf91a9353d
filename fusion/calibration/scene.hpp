#pragma once

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

/// What is taken from a sweep and a picture.
struct SceneOptions {
  /// Features to compute: relative reflectivity and discontinuity.
  PerLidarFeature<bool> lidar{false, true, false, true};
  PerImageFeature<bool> image{false, true, true};  ///< features to compute: local grey, ring edge
  features::RingDirections rings;                            ///< in this camera's pictures, for the ring edge
  features::DiscontinuityOptions discontinuity;
  NormalOptions normals;
  /// Grey and edges by rank within the picture, so that exposure does not matter. False: as
  /// they are, divided by 255.
  bool equalize = true;
  double min_range = 1.5;  ///< m; nearer returns (the vehicle itself) are left out
  double max_range = 100;  ///< m

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// A sweep and the picture that was taken with it, as features: what calibration compares.
struct Scene {
  std::string name;                           ///< for reports
  size_t camera = 0;                          ///< which camera of the rig took the picture
  std::vector<float> x, y, z;                 ///< m, lidar frame
  PerLidarFeature<std::vector<float>> lidar;  ///< a value a point; empty where not computed
  PerImageFeature<features::Plane> image;               ///< 0 … 1; empty where not computed
  std::optional<geometry::Vector6> twist;     ///< rad/s, m/s: the lidar's motion in its own frame
                                              ///< when the picture was taken, where it is known

  size_t size() const { return x.size(); }
};

/// The features of a kGrey8 or kBgr8 picture that `options` name, grey and edges by rank where they
/// say so; the other planes stay empty.
PerImageFeature<features::Plane> compute_image_features(const CameraFrame& frame,
                                              const SceneOptions& options);

/// Computes the features. The sweep should be corrected for motion to the picture's exposure.
/// Errors: a picture or a sweep with nothing in it, a Bayer mosaic.
Result<Scene> make_scene(const Sweep& sweep, const CameraFrame& frame, const SceneOptions& options);

}  // namespace infuse::calibration
