#include "fusion/target/view_weight.hpp"

namespace infuse::target {

ViewResiduals view_residuals(const TargetView& view, const ReturnsPlane& plane,
                             const Eigen::Isometry3d& T_head_lidar) {
  const Eigen::Vector3d normal = view.normal();
  ViewResiduals out;
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector3d at = T_head_lidar * plane.points.col(k);
    out.off(k) = normal.dot(at) - view.distance();
    out.by_pose.row(k) << at.cross(normal).transpose(), normal.transpose();
  }
  return out;
}

Eigen::Matrix4d residual_covariance(const TargetView& view, const ReturnsPlane& plane,
                                    const Eigen::Isometry3d& T_head_lidar, double range_noise) {
  const ViewResiduals residuals = view_residuals(view, plane, T_head_lidar);
  const Eigen::Vector3d beam = T_head_lidar.linear() * plane.mean.normalized();
  const double noise = view.normal().dot(beam) * range_noise;
  return 4 * noise * noise / static_cast<double>(view.returns.size()) *
             Eigen::Matrix4d::Identity() +
         residuals.by_pose * view.board_covariance * residuals.by_pose.transpose();
}

}  // namespace infuse::target
