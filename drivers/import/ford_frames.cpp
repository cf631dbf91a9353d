#include "drivers/import/ford_frames.hpp"

#include <numbers>

namespace infuse::importers {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

}  // namespace

Eigen::Isometry3d ford_transform(const std::array<double, 6>& pose) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Eigen::Vector3d(pose[0], pose[1], pose[2]);
  T.linear() = (Eigen::AngleAxisd(pose[5], Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(pose[4], Eigen::Vector3d::UnitY()) *
                Eigen::AngleAxisd(pose[3], Eigen::Vector3d::UnitX()))
                   .toRotationMatrix();
  return T;
}

Eigen::Isometry3d ford_T_body_vehicle() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Vector3d(1, -1, -1).asDiagonal();
  T.translation().z() = kFordAxleHeight;  // the vehicle frame is below the axle: down is positive
  return T;
}

Eigen::Isometry3d ford_T_velodyne_lidar() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  return T;
}

Eigen::Isometry3d ford_T_vehicle_lidar() {
  const Eigen::Isometry3d T_body_velodyne =
      ford_transform({2.4, -0.01, -2.3, 180 * kDegree, 0, 90 * kDegree});
  return ford_T_body_vehicle().inverse() * T_body_velodyne * ford_T_velodyne_lidar();
}

}  // namespace infuse::importers
