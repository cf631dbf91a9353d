#pragma once

#include <array>

#include "fusion/geometry/camera_model.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::geometry {

/// Error of estimated camera extrinsics against the truth.
struct ExtrinsicError {
  double rotation = 0;                ///< rad, angle of the rotation between them
  double translation = 0;             ///< m, norm of the difference of the translations
  Vector6 by_axis = Vector6::Zero();  ///< (rx, ry, rz, tx, ty, tz), estimate minus truth: rotation
                                      ///< vector and difference of the translations, in the axes of
                                      ///< the camera
  double pixels = 0;  ///< px, mean distance between the projections of the same point, over a grid
                      ///< of the image at `kComparisonDepths`
};

/// Depths at which projections are compared by definition of `pixels`, m.
inline constexpr std::array<double, 3> kComparisonDepths{5, 15, 45};

/// Compares two extrinsics T_camera_lidar of the same camera.
ExtrinsicError extrinsic_error(const Eigen::Isometry3d& T_camera_lidar_estimate,
                               const Eigen::Isometry3d& T_camera_lidar_truth,
                               const CameraModel& camera);

}  // namespace infuse::geometry
