#include "fusion/target/calibrate_target.hpp"

#include <utility>

namespace infuse::target {
namespace {

constexpr double kCloser = 0.08;   // m, of the second pass
constexpr double kInside = -0.01;  // m, of the last
constexpr double kRoughly = 0.15;  // m and rad; what else is near a board may put it so far off

TargetCalibration pass(std::span<const BoardSighting> sightings, const Board& board, double grow,
                       const Eigen::Isometry3d& T_head_lidar, const BoardReturnsOptions& finding,
                       const SolveTargetOptions& solving) {
  TargetCalibration out;
  out.returns.resize(sightings.size());
  out.missing.resize(sightings.size());
  std::vector<TargetView> views;
  std::vector<size_t> whose;
  for (size_t i = 0; i < sightings.size(); ++i) {
    const BoardSighting& seen = sightings[i];
    auto on_board =
        board_returns(seen.near, T_head_lidar.inverse() * seen.T_head_board, board, grow, finding);
    if (!on_board) {
      out.missing[i] = on_board.error().what;
      continue;
    }
    out.returns[i] = on_board->size();
    views.push_back({seen.T_head_board, seen.board_covariance, *std::move(on_board)});
    whose.push_back(i);
  }
  out.result = solve_target(views, T_head_lidar, solving);
  std::vector<ViewResidual> residuals(sightings.size(), {.used = false});
  for (size_t k = 0; k < whose.size(); ++k) residuals[whose[k]] = out.result.views[k];
  out.result.views = std::move(residuals);
  return out;
}

}  // namespace

TargetCalibration calibrate_target(std::span<const BoardSighting> sightings, const Board& board,
                                   const Eigen::Isometry3d& T_start,
                                   const BoardReturnsOptions& finding,
                                   const SolveTargetOptions& solving) {
  SolveTargetOptions roughly = solving;
  roughly.tolerated = kRoughly;
  Eigen::Isometry3d T = T_start;
  for (const double grow : {finding.margin, kCloser}) {
    T = pass(sightings, board, grow, T, finding, roughly).result.T_head_lidar;
  }
  return pass(sightings, board, kInside, T, finding, solving);
}

}  // namespace infuse::target
