#include "fusion/target/solve_intrinsics.hpp"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "fusion/target/initial_board_pose.hpp"
#include "fusion/target/pose_parameter.hpp"

namespace infuse::target {
namespace {

constexpr double kShortest = 0.15;  // of the width: equation f = width / field of view (rad) of a
                                    // fisheye that sees more than all around
constexpr double kLongest = 12;     // of the width: 5° across, by the same equation
constexpr double kFocalStep =
    1.15;                           // bounds time; the ascent converges from twice the focal length
constexpr size_t kGuessViews = 12;  // bounds time; the guess is refined on all

/// Sum of the mean squared reprojection errors of the boards, each at most that of a board that
/// does not fit at all.
double guess_cost(const geometry::CameraModel& camera, const Board& board,
                  std::span<const Corners> views, size_t stride) {
  const double worst = 0.01 * camera.intrinsics().width * camera.intrinsics().width;
  double cost = 0;
  for (size_t v = 0; v < views.size(); v += stride) {
    const auto T = estimate_initial_board_pose(camera, board, views[v]);
    double squares = 0;
    for (size_t i = 0; T && i < views[v].size(); ++i) {
      squares += (*camera.project(*T * board.corner(i)) - views[v][i]).squaredNorm();
    }
    cost += T ? std::min(worst, squares / static_cast<double>(views[v].size())) : worst;
  }
  return cost;
}

/// The camera of the shared numbers, made once for all views.
class SharedCamera : public ceres::EvaluationCallback {
 public:
  SharedCamera(const CameraIntrinsics& camera, const SharedVector& shared)
      : camera_(camera), shared_(shared) {}

  void PrepareForEvaluation(bool /*with_jacobians*/, bool new_point) override {
    if (!new_point && model_) return;
    const CameraIntrinsics camera = with_vector(camera_, shared_.head<9>());
    model_.reset();
    if (!camera.invalid()) model_.emplace(camera);
  }

  const std::optional<geometry::CameraModel>& model() const { return model_; }

 private:
  const CameraIntrinsics& camera_;
  const SharedVector& shared_;
  std::optional<geometry::CameraModel> model_;
};

/// Reprojection errors of one view.
class ViewCost : public ceres::CostFunction {
 public:
  ViewCost(const SharedCamera& camera, const PoseParameter& pose, const Board& board,
           const Corners& corners)
      : camera_(camera), pose_(pose), board_(board), corners_(corners) {
    set_num_residuals(static_cast<int>(2 * corners.size()));
    *mutable_parameter_block_sizes() = {SharedVector::RowsAtCompileTime, 6};
  }

  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override {
    if (!camera_.model()) return false;
    const auto equations =
        linearize_corners(*camera_.model(), board_, Eigen::Vector3d(parameters[0] + 9),
                          pose_.at(parameters[1]), corners_);
    if (!equations) return false;
    Eigen::Map<Eigen::VectorXd>(residuals, num_residuals()) = equations->residual;
    if (jacobians == nullptr) return true;
    using Rows12 = Eigen::Matrix<double, Eigen::Dynamic, 12, Eigen::RowMajor>;
    using Rows6 = Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>;
    if (jacobians[0] != nullptr) {
      Eigen::Map<Rows12>(jacobians[0], num_residuals(), 12) = equations->by_shared;
    }
    if (jacobians[1] != nullptr) {
      Eigen::Map<Rows6>(jacobians[1], num_residuals(), 6) =
          PoseParameter::jacobian_by_xi(equations->by_pose, parameters[1]);
    }
    return true;
  }

 private:
  const SharedCamera& camera_;
  const PoseParameter& pose_;
  const Board& board_;
  const Corners& corners_;
};

/// Prior of the board's bow.
class BowPrior : public ceres::SizedCostFunction<3, 12> {
 public:
  explicit BowPrior(double weight) : weight_(weight) {}

  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override {
    Eigen::Map<Eigen::Vector3d> residual(residuals);
    residual = weight_ * Eigen::Vector3d(parameters[0] + 9);
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 3, 12, Eigen::RowMajor>> jacobian(jacobians[0]);
      jacobian.setZero();
      jacobian.rightCols<3>() = weight_ * Eigen::Matrix3d::Identity();
    }
    return true;
  }

 private:
  double weight_;
};

}  // namespace

std::optional<IntrinsicsSolution> guess_intrinsics(const CameraIntrinsics& camera,
                                                   const Board& board,
                                                   std::span<const Corners> views) {
  const size_t stride = std::max<size_t>(1, views.size() / kGuessViews);
  IntrinsicsSolution best;
  double best_cost = std::numeric_limits<double>::infinity();
  for (double focal = kShortest * camera.width; focal < kLongest * camera.width;
       focal *= kFocalStep) {
    IntrinsicsVector numbers = IntrinsicsVector::Zero();
    numbers.head<4>() << focal, focal, 0.5 * (camera.width - 1), 0.5 * (camera.height - 1);
    const CameraIntrinsics guess = with_vector(camera, numbers);
    const double cost = guess_cost(geometry::CameraModel(guess), board, views, stride);
    if (!(cost < best_cost)) continue;
    best_cost = cost;
    best.camera = guess;
  }
  size_t found = 0;
  const geometry::CameraModel model(best.camera);
  for (const Corners& corners : views) {
    best.T_camera_board.push_back(estimate_initial_board_pose(model, board, corners));
    found += best.T_camera_board.back().has_value();
  }
  if (views.empty() || 2 * found < views.size()) return std::nullopt;
  return best;
}

void solve_intrinsics(const Board& board, std::span<const Corners> views,
                      const std::vector<bool>& used, const IntrinsicsWeights& weights,
                      IntrinsicsSolution& solution) {
  SharedVector shared;
  shared << to_vector(solution.camera), solution.bow;
  SharedCamera camera(solution.camera, shared);
  std::vector<PoseParameter> poses(views.size());
  std::vector<geometry::Vector6> twists(views.size(), geometry::Vector6::Zero());

  ceres::Problem::Options problem_options;
  problem_options.evaluation_callback = &camera;
  ceres::Problem problem(problem_options);
  problem.AddParameterBlock(shared.data(), 12);
  if (intrinsics_count(solution.camera.model) < 9) {
    problem.SetManifold(shared.data(), new ceres::SubsetManifold(12, {8}));
  }
  problem.AddResidualBlock(new BowPrior(weights.corner_noise / weights.flatness), nullptr,
                           shared.data());
  for (size_t v = 0; v < views.size(); ++v) {
    if (!used[v] || !solution.T_camera_board[v]) continue;
    poses[v].T_initial = *solution.T_camera_board[v];
    const double allowed = weights.robust_rms * std::sqrt(static_cast<double>(views[v].size()));
    problem.AddResidualBlock(new ViewCost(camera, poses[v], board, views[v]),
                             allowed > 0 ? new ceres::CauchyLoss(allowed) : nullptr, shared.data(),
                             twists[v].data());
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = 200;    // bounds time
  options.function_tolerance = 1e-12;  // relative; far below a statistic's change, double precision
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);

  solution.converged = summary.termination_type == ceres::CONVERGENCE;
  solution.camera = with_vector(solution.camera, shared.head<9>());
  solution.bow = shared.tail<3>();
  for (size_t v = 0; v < views.size(); ++v) {
    if (used[v] && solution.T_camera_board[v])
      solution.T_camera_board[v] = poses[v].at(twists[v].data());
  }
}

}  // namespace infuse::target
