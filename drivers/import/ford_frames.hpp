#pragma once

#include <Eigen/Geometry>
#include <array>

namespace infuse::importers {

/// Height of the body frame, the centre of the rear axle, above the ground, m. The thesis does not
/// state it; it is the radius of the tyres that a Ford F-250 of that time has.
inline constexpr double kFordAxleHeight = 0.4;

/// X_ab of P, appendix C: x, y, z in m, then roll, pitch, heading in rad, which turn about the
/// fixed axes x, y, z in this order.
Eigen::Isometry3d ford_transform(const std::array<double, 6>& pose);

/// From the vehicle frame to the body frame of P: x forward, y right, z down, on the rear axle.
Eigen::Isometry3d ford_T_body_vehicle();

/// From the lidar frame to that of Velodyne's manual: x right, y forward, z up.
Eigen::Isometry3d ford_T_velodyne_lidar();

/// Pose of the lidar by table C.1.
Eigen::Isometry3d ford_T_vehicle_lidar();

}  // namespace infuse::importers
