#include "fusion/target/calibrate_target.hpp"

#include <utility>

namespace infuse::target {
namespace {

constexpr double kSecondPassMargin = 0.08;  // m, second pass
constexpr double kLastPassMargin = -0.01;   // m, last pass

TargetCalibration run_pass(std::span<const BoardObservation> observations, const Board& board,
                           double grow, const Eigen::Isometry3d& T_refcam_lidar,
                           const BoardReturnsOptions& returns_options,
                           const SolveTargetOptions& solve_options) {
  TargetCalibration out;
  out.return_counts.resize(observations.size());
  out.reasons.resize(observations.size());
  std::vector<TargetView> views;
  std::vector<size_t> observation_index;
  for (size_t i = 0; i < observations.size(); ++i) {
    const BoardObservation& observation = observations[i];
    auto on_board = find_board_returns(observation.nearby_returns,
                                       T_refcam_lidar.inverse() * observation.T_refcam_board, board,
                                       grow, returns_options);
    if (!on_board) {
      out.reasons[i] = on_board.error().what;
      continue;
    }
    out.return_counts[i] = on_board->size();
    views.push_back(
        {observation.T_refcam_board, observation.board_covariance, *std::move(on_board), board});
    observation_index.push_back(i);
  }
  out.result = solve_target(views, T_refcam_lidar, solve_options);
  std::vector<ViewResidual> residuals(observations.size(), {.used = false});
  for (size_t k = 0; k < observation_index.size(); ++k)
    residuals[observation_index[k]] = out.result.views[k];
  out.result.views = std::move(residuals);
  return out;
}

}  // namespace

TargetCalibration calibrate_target(std::span<const BoardObservation> observations,
                                   const Board& board, const Eigen::Isometry3d& T_initial,
                                   const BoardReturnsOptions& returns_options,
                                   const SolveTargetOptions& solve_options) {
  Eigen::Isometry3d T = T_initial;
  for (const double grow : {returns_options.margin, kSecondPassMargin}) {
    T = run_pass(observations, board, grow, T, returns_options, solve_options)
            .result.T_refcam_lidar;
  }
  return run_pass(observations, board, kLastPassMargin, T, returns_options, solve_options);
}

}  // namespace infuse::target
