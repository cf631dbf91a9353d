#pragma once

#include <array>

#include "fusion/geometry/camera_model.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::geometry {

/// How far an estimate of a camera's extrinsics is from the truth.
struct ExtrinsicError {
  double rotation = 0;                ///< rad, angle of the whole rotation between them
  double translation = 0;             ///< m, length of the difference of their translations
  Vector6 by_axis = Vector6::Zero();  ///< (rx, ry, rz, tx, ty, tz), estimate minus truth: the
                                      ///< rotation between them and the difference of their
                                      ///< translations, about and along the camera's axes
  double pixels = 0;  ///< mean distance between where the two put the same point, over a grid
                      ///< of the picture at `kComparisonDepths`
};

/// The distances at which pixels are compared, m.
inline constexpr std::array<double, 3> kComparisonDepths{5, 15, 45};

/// Compares two extrinsics T_camera_lidar of one camera.
ExtrinsicError extrinsic_error(const Eigen::Isometry3d& T_camera_lidar_estimate,
                               const Eigen::Isometry3d& T_camera_lidar_truth,
                               const CameraModel& camera);

}  // namespace infuse::geometry
