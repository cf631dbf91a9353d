#include "fusion/geometry/extrinsic_error.hpp"

namespace infuse::geometry {
namespace {

/// Mean distance in pixels between where a point seen by the true camera is, and where the estimate
/// puts it.
double mean_pixels(const Eigen::Isometry3d& T_estimate_truth, const CameraModel& camera) {
  constexpr int kGrid = 12;  // cells along each side of the picture
  double sum = 0;
  int count = 0;
  for (int row = 0; row < kGrid; ++row) {
    for (int column = 0; column < kGrid; ++column) {
      const Eigen::Vector2d pixel((column + 0.5) * camera.intrinsics().width / kGrid - 0.5,
                                  (row + 0.5) * camera.intrinsics().height / kGrid - 0.5);
      const auto direction = camera.unproject(pixel);
      if (!direction) continue;
      for (const double depth : kDepths) {
        const auto moved = camera.project(T_estimate_truth * Eigen::Vector3d(depth * *direction));
        if (!moved) continue;
        sum += (*moved - pixel).norm();
        ++count;
      }
    }
  }
  return count > 0 ? sum / count : 0;
}

}  // namespace

ExtrinsicError extrinsic_error(const Eigen::Isometry3d& T_camera_lidar_estimate,
                               const Eigen::Isometry3d& T_camera_lidar_truth,
                               const CameraModel& camera) {
  const Eigen::Isometry3d T_estimate_truth =
      T_camera_lidar_estimate * T_camera_lidar_truth.inverse();
  ExtrinsicError error;
  error.rotation = Eigen::AngleAxisd(T_estimate_truth.linear()).angle();
  const Eigen::Vector3d shift =
      T_camera_lidar_estimate.translation() - T_camera_lidar_truth.translation();
  error.translation = shift.norm();
  error.by_axis << rotation_log(T_estimate_truth.linear()), shift;
  error.pixels = mean_pixels(T_estimate_truth, camera);
  return error;
}

}  // namespace infuse::geometry
