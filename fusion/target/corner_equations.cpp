#include "fusion/target/corner_equations.hpp"

namespace infuse::target {

std::optional<CornerEquations> linearize_corners(const geometry::CameraModel& camera,
                                                 const Board& board, const Eigen::Vector3d& bow,
                                                 const Eigen::Isometry3d& T_camera_board,
                                                 const Corners& corners) {
  const auto rows = static_cast<Eigen::Index>(2 * corners.size());
  CornerEquations out{Eigen::VectorXd(rows), Eigen::MatrixXd(rows, 12), Eigen::MatrixXd(rows, 6)};
  const Eigen::Vector3d normal = T_camera_board.linear().col(2);
  const Eigen::Vector2d half = board.half_size();
  for (size_t i = 0; i < corners.size(); ++i) {
    Eigen::Vector3d corner = board.corner(i);
    const Eigen::Vector3d by_bow =
        board.bow_at((corner - board.middle()).head<2>().cwiseQuotient(half));
    corner.z() += by_bow.dot(bow);
    const Eigen::Vector3d point = T_camera_board * corner;
    const auto projected = camera.project_with_derivatives(point);
    if (!projected) return std::nullopt;
    const auto row = static_cast<Eigen::Index>(2 * i);
    out.residual.segment<2>(row) = projected->pixel - corners[i];
    out.by_shared.block<2, 9>(row, 0) = derivative_by_intrinsics(camera.intrinsics(), point);
    out.by_shared.block<2, 3>(row, 9) = projected->by_point * normal * by_bow.transpose();
    out.by_pose.middleRows<2>(row) = projected->by_pose;
  }
  return out;
}

}  // namespace infuse::target
