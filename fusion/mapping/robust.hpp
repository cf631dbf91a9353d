#pragma once

#include <vector>

#include "fusion/mapping/optimize.hpp"

namespace infuse::mapping {

/// The optimum without false closures, and which those are.
struct RobustResult {
  OptimizeResult optimized;    ///< without the rejected closures
  std::vector<char> accepted;  ///< of each edge: 0 for rejected closures
  std::vector<double> chi2;    ///< of each edge at the optimum
  size_t accepted_closures = 0, rejected_closures = 0;
  const char* reason = "not optimised";  ///< static text; empty if the poses are usable

  bool usable() const { return *reason == '\0'; }
};

/// Optimises a graph some of whose closures are false: those of `consistent_edges` first, from the
/// chordal initialisation, then, until nothing changes, those whose χ² at the optimum is below a
/// limit (truncated least squares). The limit is that of the stated information, or 1000 times the
/// median of the closures where they agree far better than they state. Groups of closures with a
/// high χ² are then left out on trial, and stay out where the truncated cost is lower. Not usable
/// if the edges do not determine the poses or more closures are rejected than accepted.
/// `options.invalid()` must be empty.
template <int D>
RobustResult optimize_robustly(PoseGraph<D>& graph, const OptimizeOptions& options = {});

}  // namespace infuse::mapping
