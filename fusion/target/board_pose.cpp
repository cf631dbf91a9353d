#include "fusion/target/board_pose.hpp"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "fusion/target/pose_parameter.hpp"

namespace infuse::target {
namespace {

using geometry::Matrix6;
using geometry::Vector6;

constexpr double kWorstFit = 2;  // px

/// A pose from OpenCV, on the plane at unit distance: no camera model is needed there.
std::optional<Eigen::Isometry3d> start_pose(const geometry::CameraModel& camera, const Board& board,
                                            const Corners& corners) {
  std::vector<cv::Point3d> on_board;
  std::vector<cv::Point2d> seen;
  for (size_t i = 0; i < corners.size(); ++i) {
    const auto ray = camera.unproject(corners[i]);
    if (!ray || !(ray->z() > 0.05)) return std::nullopt;
    const Eigen::Vector3d corner = board.corner(i) - board.middle();
    on_board.emplace_back(corner.x(), corner.y(), corner.z());
    seen.emplace_back(ray->x() / ray->z(), ray->y() / ray->z());
  }
  cv::Mat turn, shift;
  try {
    if (!cv::solvePnP(on_board, seen, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), turn, shift, false,
                      cv::SOLVEPNP_IPPE)) {
      return std::nullopt;
    }
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = geometry::rotation_exp({turn.at<double>(0), turn.at<double>(1), turn.at<double>(2)});
  T.translation() = Eigen::Vector3d(shift.at<double>(0), shift.at<double>(1), shift.at<double>(2)) -
                    T.linear() * board.middle();
  if (!T.matrix().allFinite()) return std::nullopt;
  for (size_t i = 0; i < corners.size(); ++i) {
    if (!camera.project(T * board.corner(i))) return std::nullopt;
  }
  return T;
}

/// How far one corner lies from where the pose puts it, pixels.
class CornerCost : public ceres::SizedCostFunction<2, 6> {
 public:
  CornerCost(const geometry::CameraModel& camera, const PoseParameter& pose,
             const Eigen::Vector3d& corner, const Eigen::Vector2d& seen)
      : camera_(camera), pose_(pose), corner_(corner), seen_(seen) {}

  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override {
    const auto put = camera_.project_with_derivatives(pose_.at(parameters[0]) * corner_);
    if (!put) return false;
    Eigen::Map<Eigen::Vector2d> residual(residuals);
    residual = put->pixel - seen_;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, 6, Eigen::RowMajor>> jacobian(jacobians[0]);
      jacobian = PoseParameter::by_xi(put->by_pose, parameters[0]);
    }
    return true;
  }

 private:
  const geometry::CameraModel& camera_;
  const PoseParameter& pose_;
  Eigen::Vector3d corner_;
  Eigen::Vector2d seen_;
};

}  // namespace

std::optional<BoardPose> board_pose(const geometry::CameraModel& camera, const Board& board,
                                    const Corners& corners, double corner_noise) {
  if (corners.size() != board.corners()) return std::nullopt;
  const auto start = start_pose(camera, board, corners);
  if (!start) return std::nullopt;

  const PoseParameter pose{*start};
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
    const auto put = camera.project_with_derivatives(out.T_camera_board * board.corner(i));
    if (!put) return std::nullopt;
    squares += (put->pixel - corners[i]).squaredNorm();
    information += put->by_pose.transpose() * put->by_pose;
  }
  const auto n = static_cast<double>(corners.size());
  out.rms = std::sqrt(squares / n);
  if (!(out.rms <= kWorstFit)) return std::nullopt;
  const double noise = std::max(corner_noise, std::sqrt(squares / (2 * n - 6)));
  out.covariance = noise * noise * information.inverse();
  if (!out.covariance.allFinite()) return std::nullopt;
  return out;
}

}  // namespace infuse::target
