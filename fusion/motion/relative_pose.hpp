#pragma once

#include "drivers/measurement/stamp.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::motion {

/// Measured motion of the vehicle between two times, as registration of sweeps gives it.
struct RelativePose {
  Stamp from, to;
  Eigen::Isometry3d T_from_to = Eigen::Isometry3d::Identity();  ///< vehicle frame at `to` expressed
                                                                ///< in the vehicle frame at `from`
  /// Inverse of the covariance of the left perturbation in the vehicle frame at `from`, in the
  /// order (rx, ry, rz, tx, ty, tz), rad and m. Directions that the geometry leaves free have no
  /// information.
  geometry::Matrix6 information = geometry::Matrix6::Zero();
};

}  // namespace infuse::motion
