#include "fusion/geometry/extrinsic_error.hpp"

namespace infuse::geometry {
namespace {

/// Mean distance in pixels between the true and the estimated projection of points in the true
/// camera's view.
double mean_pixel_error(const Eigen::Isometry3d& T_estimate_truth, const CameraModel& camera) {
  constexpr int kGridSize = 12;  // cells along each side of the image, by definition
  double sum = 0;
  int count = 0;
  for (int row = 0; row < kGridSize; ++row) {
    for (int column = 0; column < kGridSize; ++column) {
      const Eigen::Vector2d pixel((column + 0.5) * camera.intrinsics().width / kGridSize - 0.5,
                                  (row + 0.5) * camera.intrinsics().height / kGridSize - 0.5);
      const auto direction = camera.unproject(pixel);
      if (!direction) continue;
      for (const double depth : kComparisonDepths) {
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
  error.pixels = mean_pixel_error(T_estimate_truth, camera);
  return error;
}

}  // namespace infuse::geometry
