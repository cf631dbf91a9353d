// Target-based calibration: error against the number of views (P fig. 3.4) and the area of the
// board (P fig. 3.5), and the estimated standard deviation. The range noise is 2 cm, a Velodyne's;
// Root mean squares over
// twenty runs, three axes summed. Times are wall seconds per run.

#include <benchmark/benchmark.h>

#include <cmath>

#include "drivers/measurement/angles.hpp"
#include "fusion/target/solve_target.hpp"
#include "tests/fusion/target/synthetic_views.hpp"

namespace infuse::target {
namespace {

constexpr double kRangeNoise = 0.02;  // m

void solve(benchmark::State& state, int views, const Board& board) {
  constexpr uint64_t kRuns = 20;
  const Eigen::Isometry3d truth = synthetic::true_T_camera_lidar();
  const Eigen::Isometry3d initial_guess = synthetic::perturb(truth, 0.05, 0.1);
  const SolveTargetOptions options;
  geometry::Vector6 squares = geometry::Vector6::Zero(), variances = geometry::Vector6::Zero();
  double usable = 0;
  for (auto _ : state) {
    squares.setZero();
    variances.setZero();
    usable = 0;
    for (uint64_t seed = 1; seed <= kRuns; ++seed) {
      const auto seen = synthetic::make_views(views, seed, board, kRangeNoise);
      const TargetResult result = solve_target(seen, initial_guess, options);
      squares += geometry::log(result.T_refcam_lidar * truth.inverse()).cwiseAbs2() / kRuns;
      variances += result.covariance.diagonal() / kRuns;
      usable += result.usable() ? 1 : 0;
    }
  }
  state.counters["error_deg"] = std::sqrt(squares.head<3>().sum()) / kDegree;
  state.counters["sigma_deg"] = std::sqrt(variances.head<3>().sum()) / kDegree;
  state.counters["error_cm"] = 100 * std::sqrt(squares.tail<3>().sum());
  state.counters["sigma_cm"] = 100 * std::sqrt(variances.tail<3>().sum());
  state.counters["usable_percent"] = 100 * usable / kRuns;
}

void by_views(benchmark::State& state) {
  solve(state, static_cast<int>(state.range(0)), synthetic::board());
}

/// Squares sized for a board of the given area in hundredths of a square metre.
void by_area(benchmark::State& state) {
  Board board = synthetic::board();
  const double cells = (board.columns + 1) * (board.rows + 1);
  board.square_size = std::sqrt(static_cast<double>(state.range(0)) / 100 / cells);
  solve(state, 10, board);
}

BENCHMARK(by_views)
    ->Name("target/views")
    ->ArgsProduct({{3, 5, 10, 20, 30, 50}})
    ->Iterations(1)
    ->Unit(benchmark::kSecond);
BENCHMARK(by_area)
    ->Name("target/area")
    ->ArgsProduct({{20, 40, 80, 160}})
    ->Iterations(1)
    ->Unit(benchmark::kSecond);

}  // namespace
}  // namespace infuse::target
