#include "fusion/target/view_residuals.hpp"

namespace infuse::target {

LinearisedView linearise_view(const TargetView& view, const ReturnsPlane& plane,
                              const Eigen::Isometry3d& T_refcam_lidar) {
  const Eigen::Vector3d normal = view.normal();
  LinearisedView out;
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector3d at = T_refcam_lidar * plane.points.col(k);
    out.residuals(k) = normal.dot(at) - view.distance();
    out.jacobian.row(k) << at.cross(normal).transpose(), normal.transpose();
  }
  return out;
}

Eigen::Matrix4d residual_covariance(const TargetView& view, const ReturnsPlane& plane,
                                    const Eigen::Isometry3d& T_refcam_lidar, double range_noise) {
  const LinearisedView residuals = linearise_view(view, plane, T_refcam_lidar);
  const Eigen::Vector3d beam = T_refcam_lidar.linear() * plane.mean.normalized();
  const double noise = view.normal().dot(beam) * range_noise;
  return 4 * noise * noise / static_cast<double>(view.returns.size()) *
             Eigen::Matrix4d::Identity() +
         residuals.jacobian * view.board_covariance * residuals.jacobian.transpose();
}

}  // namespace infuse::target
