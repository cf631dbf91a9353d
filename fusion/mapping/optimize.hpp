#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fusion/mapping/block_cholesky.hpp"
#include "fusion/mapping/edge_cost.hpp"
#include "fusion/mapping/pose_graph.hpp"

namespace infuse::mapping {

/// Settings of the optimisation of a pose graph.
struct OptimizeOptions {
  Cost cost = Cost::kInformation;  ///< which is minimised
  int max_iterations = 100;        ///< factorisations; bounds time
  double tolerance = 1e-9;         ///< relative decrease of the cost below which it has converged

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Costs before and after, and whether the poses may be used.
struct OptimizeResult {
  double initial_cost = 0, cost = 0;     ///< before and after
  int iterations = 0;                    ///< factorisations
  const char* reason = "not optimised";  ///< static text; empty if the poses are usable

  bool usable() const { return *reason == '\0'; }  ///< they may be used
};

/// Poses that minimise the cost of a graph, by Gauss–Newton with the damping of Levenberg and
/// Marquardt. Pose 0 is held. Keeps the structure of the matrix between calls: `graph` is the same
/// but for its poses.
template <int D>
class PoseGraphSolver {
 public:
  /// Analyses the structure of the graph.
  explicit PoseGraphSolver(const PoseGraph<D>& graph);

  /// Moves the poses of `graph`. `options.invalid()` must be empty.
  OptimizeResult optimize(PoseGraph<D>& graph, const OptimizeOptions& options = {});

  /// Covariances of `poses` given pose 0, of the left perturbation in the map frame, rotation first
  /// ((angle, x, y) or (rx, ry, rz, tx, ty, tz)), rad and m; that of pose 0 is zero. Empty if the
  /// edges do not determine the poses. Gauss–Newton's: without the second derivatives of residuals.
  std::vector<PoseMatrix<D>> covariances(const PoseGraph<D>& graph,
                                         const std::vector<size_t>& poses);

 private:
  double linearize(const PoseGraph<D>& graph, Cost cost);

  BlockCholesky<kPoseFreedom<D>> system_;
  Eigen::VectorXd gradient_;
};

/// Sum of the costs of all edges.
template <int D>
double total_cost(const PoseGraph<D>& graph, Cost cost);

}  // namespace infuse::mapping
