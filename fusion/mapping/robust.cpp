#include "fusion/mapping/robust.hpp"

#include <algorithm>

#include "fusion/mapping/chi2.hpp"
#include "fusion/mapping/chordal_initialisation.hpp"
#include "fusion/mapping/cycle_consistency.hpp"

namespace infuse::mapping {
namespace {

constexpr int kMaxPasses = 10;
constexpr double kScaleLimit = 1000;

/// Optimises all poses by the accepted edges.
template <int D>
OptimizeResult optimize_accepted(PoseGraph<D>& graph, const std::vector<char>& accepted,
                                 bool initialise, const OptimizeOptions& options) {
  PoseGraph<D> part;
  part.poses = graph.poses;
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    if (accepted[e] != 0) part.edges.push_back(graph.edges[e]);
  }
  OptimizeResult result;
  if (initialise && !initialise_chordal(part)) {
    result.reason = "the edges do not determine the poses";
    return result;
  }
  result = PoseGraphSolver<D>(part).optimize(part, options);
  graph.poses = std::move(part.poses);
  return result;
}

}  // namespace

template <int D>
RobustResult optimize_robustly(PoseGraph<D>& graph, const OptimizeOptions& options) {
  RobustResult result;
  if (graph.poses.size() < 2) {
    result.reason = "the graph has fewer than two poses";
    return result;
  }
  result.accepted = consistent_edges(graph);
  result.chi2.resize(graph.edges.size());
  bool changed = true;
  for (int pass = 0; changed && pass < kMaxPasses; ++pass) {
    result.optimized = optimize_accepted(graph, result.accepted, pass == 0, options);
    if (!result.optimized.usable()) {
      result.reason = result.optimized.reason;
      return result;
    }
    std::vector<double> of_accepted;
    for (size_t e = 0; e < graph.edges.size(); ++e) {
      const PoseEdge<D>& edge = graph.edges[e];
      result.chi2[e] =
          edge_cost<D>(edge, graph.poses[edge.from], graph.poses[edge.to], Cost::kInformation);
      if (edge.closure && result.accepted[e] != 0) of_accepted.push_back(result.chi2[e]);
    }
    const double limit = std::min(kScaleLimit * chi2_scale<D>(of_accepted), kChi2Limit<D>);
    changed = false;
    for (size_t e = 0; e < graph.edges.size(); ++e) {
      if (!graph.edges[e].closure) continue;
      const char accepted = result.chi2[e] <= limit;
      changed |= accepted != result.accepted[e];
      result.accepted[e] = accepted;
    }
  }
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    if (!graph.edges[e].closure) continue;
    ++(result.accepted[e] != 0 ? result.accepted_closures : result.rejected_closures);
  }
  result.reason = changed ? "which closures are false is not settled"
                  : result.rejected_closures > result.accepted_closures
                      ? "more closures are rejected than accepted"
                      : "";
  return result;
}

template RobustResult optimize_robustly(PoseGraph<2>&, const OptimizeOptions&);
template RobustResult optimize_robustly(PoseGraph<3>&, const OptimizeOptions&);

}  // namespace infuse::mapping
