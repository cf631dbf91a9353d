#pragma once

#include <string>

#include "daemon/playback/calibration_scenes.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::daemon {

/// What the vehicle's motion can have done to a calibration beyond the scatter of the scenes: an
/// error of the exposures' times, or of the returns' times, moves all scenes alike.
struct MotionUncertainty {
  /// To be added to that of the result: left perturbation of T_refcam_lidar, rad and m.
  geometry::Matrix6 covariance = geometry::Matrix6::Zero();
  double max_shift = 0;  ///< m; speed × time, over which sweeps that are not deskewed are blurred
  std::string reason;    ///< why a result cannot be used; empty if it can
  std::string note;      ///< statement for the user; may be empty
};

/// Maximum `max_shift`, m: what motion does is then no more than a calibration's own error.
inline constexpr double kMaxUncompensatedShift = 0.05;

/// Returns the uncertainty at a result. With ξ a scene's twist and dt an error of its time, the
/// scene fits best at exp(−Ad ξ dt) T_refcam_lidar. dt is the standard deviation of the camera's
/// delay and, if the sweep is not deskewed, uniform up to `ScenePair::uncompensated`. Where the
/// motion is not known, the note says so. `refined_delay`: the delay was estimated from these
/// pairs, its standard deviation is no part of this.
MotionUncertainty motion_uncertainty(const ScenePairs& pairs,
                                     const Eigen::Isometry3d& T_refcam_lidar,
                                     bool refined_delay = false);

}  // namespace infuse::daemon
