#include "fusion/calibration/ring_directions.hpp"

namespace infuse::calibration {
namespace {

constexpr double kMinAxisAngle = 1e-3;  // rad from the axis: there a ring is a point

/// Of unit length, or zero.
Eigen::Vector2d direction_at(const geometry::CameraModel& camera, const Eigen::Vector3d& axis,
                             const Eigen::Vector2d& pixel) {
  const auto along = camera.unproject(pixel);
  if (!along || along->cross(axis).norm() < kMinAxisAngle) return Eigen::Vector2d::Zero();
  const auto seen = camera.project_with_derivatives(*along);
  if (!seen) return Eigen::Vector2d::Zero();
  return (seen->by_point * axis.cross(*along)).normalized();
}

}  // namespace

RingDirections ring_directions(const geometry::CameraModel& camera,
                               const Eigen::Isometry3d& T_camera_lidar) {
  constexpr int kSquare = RingDirections::kCellSize;
  const CameraIntrinsics& intrinsics = camera.intrinsics();
  const Eigen::Vector3d axis = T_camera_lidar.linear().col(2);
  RingDirections rings{.columns = (intrinsics.width + kSquare - 1) / kSquare,
                       .rows = (intrinsics.height + kSquare - 1) / kSquare};
  for (int top = 0; top < intrinsics.height; top += kSquare) {
    for (int left = 0; left < intrinsics.width; left += kSquare) {
      const Eigen::Vector2d middle(left + (kSquare - 1) / 2.0, top + (kSquare - 1) / 2.0);
      const Eigen::Vector2f direction = direction_at(camera, axis, middle).cast<float>();
      rings.right.push_back(direction.x());
      rings.down.push_back(direction.y());
    }
  }
  return rings;
}

}  // namespace infuse::calibration
