#include "fusion/features/ring_directions.hpp"

namespace infuse::features {
namespace {

constexpr double kMinAxisAngle = 1e-3;  // rad from the axis, where a ring is a point

/// Direction of the ring at a pixel, of unit length, or zero.
Eigen::Vector2d direction_at(const geometry::CameraModel& camera, const Eigen::Vector3d& axis,
                             const Eigen::Vector2d& pixel) {
  const auto along = camera.unproject(pixel);
  if (!along || along->cross(axis).norm() < kMinAxisAngle) return Eigen::Vector2d::Zero();
  const auto seen = camera.project_with_derivatives(*along);
  if (!seen) return Eigen::Vector2d::Zero();
  return (seen->by_point * axis.cross(*along)).normalized();
}

}  // namespace

void find_ring_directions(const geometry::CameraModel& camera,
                          const Eigen::Isometry3d& T_camera_lidar, int step,
                          RingDirections& rings) {
  const int cell = RingDirections::kCellSize * step;  // px
  const CameraIntrinsics& intrinsics = camera.intrinsics();
  const Eigen::Vector3d axis = T_camera_lidar.linear().col(2);
  rings.columns = (intrinsics.width + cell - 1) / cell;
  rings.rows = (intrinsics.height + cell - 1) / cell;
  rings.right.clear();
  rings.down.clear();
  for (int top = 0; top < intrinsics.height; top += cell) {
    for (int left = 0; left < intrinsics.width; left += cell) {
      const Eigen::Vector2d middle(left + (cell - 1) / 2.0, top + (cell - 1) / 2.0);
      const Eigen::Vector2f direction = direction_at(camera, axis, middle).cast<float>();
      rings.right.push_back(direction.x());
      rings.down.push_back(direction.y());
    }
  }
}

RingDirections ring_directions(const geometry::CameraModel& camera,
                               const Eigen::Isometry3d& T_camera_lidar) {
  RingDirections rings;
  find_ring_directions(camera, T_camera_lidar, 1, rings);
  return rings;
}

}  // namespace infuse::features
