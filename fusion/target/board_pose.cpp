#include "fusion/target/board_pose.hpp"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>

#include "fusion/target/initial_board_pose.hpp"
#include "fusion/target/pose_parameter.hpp"

namespace infuse::target {
namespace {

using geometry::Matrix6;
using geometry::Vector6;

constexpr double kMaxRms = 2;  // px

/// Reprojection error of one corner, pixels.
class CornerCost : public ceres::SizedCostFunction<2, 6> {
 public:
  CornerCost(const geometry::CameraModel& camera, const PoseParameter& pose,
             const Eigen::Vector3d& corner, const Eigen::Vector2d& observed)
      : camera_(camera), pose_(pose), corner_(corner), observed_(observed) {}

  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override {
    const auto projected = camera_.project_with_derivatives(pose_.at(parameters[0]) * corner_);
    if (!projected) return false;
    Eigen::Map<Eigen::Vector2d> residual(residuals);
    residual = projected->pixel - observed_;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, 6, Eigen::RowMajor>> jacobian(jacobians[0]);
      jacobian = PoseParameter::jacobian_by_xi(projected->by_pose, parameters[0]);
    }
    return true;
  }

 private:
  const geometry::CameraModel& camera_;
  const PoseParameter& pose_;
  Eigen::Vector3d corner_;
  Eigen::Vector2d observed_;
};

}  // namespace

std::optional<BoardPose> estimate_board_pose(const geometry::CameraModel& camera,
                                             const Board& board, const Corners& corners,
                                             double corner_noise) {
  if (corners.size() != board.corner_count()) return std::nullopt;
  const auto initial_pose = estimate_initial_board_pose(camera, board, corners);
  if (!initial_pose) return std::nullopt;

  const PoseParameter pose{*initial_pose};
  Vector6 xi = Vector6::Zero();
  ceres::Problem problem;
  for (size_t i = 0; i < corners.size(); ++i) {
    problem.AddResidualBlock(new CornerCost(camera, pose, board.corner(i), corners[i]), nullptr,
                             xi.data());
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) return std::nullopt;

  BoardPose out{.T_camera_board = pose.at(xi.data())};
  Matrix6 information = Matrix6::Zero();
  double squares = 0;
  for (size_t i = 0; i < corners.size(); ++i) {
    const auto projected = camera.project_with_derivatives(out.T_camera_board * board.corner(i));
    if (!projected) return std::nullopt;
    squares += (projected->pixel - corners[i]).squaredNorm();
    information += projected->by_pose.transpose() * projected->by_pose;
  }
  const auto n = static_cast<double>(corners.size());
  out.rms = std::sqrt(squares / n);
  if (!(out.rms <= kMaxRms)) return std::nullopt;
  const double noise = std::max(corner_noise, std::sqrt(squares / (2 * n - 6)));
  out.covariance = noise * noise * information.inverse();
  if (!out.covariance.allFinite()) return std::nullopt;
  return out;
}

}  // namespace infuse::target
