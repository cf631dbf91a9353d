#include "fusion/mapping/robust.hpp"

#include <algorithm>
#include <limits>

#include "fusion/mapping/chi2.hpp"
#include "fusion/mapping/chordal_initialisation.hpp"
#include "fusion/mapping/closure_groups.hpp"
#include "fusion/mapping/cycle_consistency.hpp"

namespace infuse::mapping {
namespace {

constexpr int kMaxPasses = 10;        // decision 17
constexpr double kScaleLimit = 1000;  // decision 17
// Of a group's mean χ², in units of that of all closures (decision 17).
constexpr double kSuspicious = 2;
constexpr double kBetter = 5;   // χ²; less is chance (decision 14)
constexpr int kMaxTrials = 10;  // without a group; each costs an optimisation or more (decision 14)

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
  if (first_unconnected(part) < part.poses.size() || (initialise && !initialise_chordal(part))) {
    result.reason = "the edges do not determine the poses";
    return result;
  }
  result = PoseGraphSolver<D>(part).optimize(part, options);
  graph.poses = std::move(part.poses);
  return result;
}

/// Accepted closures that another pass would not change, unless `changed`.
struct Settled {
  OptimizeResult optimized;
  std::vector<char> accepted;
  std::vector<double> chi2;
  bool changed = true;
  // Truncated: no closure counts more than the limit of χ². Infinite without an optimum.
  double cost = 0;
};

/// Optimises and accepts the closures below a limit in turn, until nothing changes.
template <int D>
Settled settle(PoseGraph<D>& graph, std::vector<char> accepted, bool initialise,
               const OptimizeOptions& options) {
  Settled result;
  result.accepted = std::move(accepted);
  result.chi2.resize(graph.edges.size());
  for (int pass = 0; result.changed && pass < kMaxPasses; ++pass) {
    result.optimized = optimize_accepted(graph, result.accepted, initialise && pass == 0, options);
    std::vector<double> of_accepted;
    for (size_t e = 0; e < graph.edges.size(); ++e) {
      const PoseEdge<D>& edge = graph.edges[e];
      result.chi2[e] =
          edge_cost<D>(edge, graph.poses[edge.from], graph.poses[edge.to], Cost::kInformation);
      if (edge.closure && result.accepted[e] != 0) of_accepted.push_back(result.chi2[e]);
    }
    if (!result.optimized.usable()) {
      result.cost = std::numeric_limits<double>::infinity();
      return result;
    }
    const double limit = std::min(kScaleLimit * chi2_scale<D>(of_accepted), kChi2Limit<D>);
    result.changed = false;
    result.cost = 0;
    for (size_t e = 0; e < graph.edges.size(); ++e) {
      result.cost +=
          graph.edges[e].closure ? std::min(result.chi2[e], kChi2Limit<D>) : result.chi2[e];
      if (!graph.edges[e].closure) continue;
      const char accept = result.chi2[e] <= limit;
      result.changed |= accept != result.accepted[e];
      result.accepted[e] = accept;
    }
  }
  return result;
}

/// Groups whose χ² is well above that of all accepted closures, the highest sum first.
template <int D>
std::vector<std::vector<size_t>> suspicious_groups(const PoseGraph<D>& graph,
                                                   const Settled& settled) {
  std::vector<std::vector<size_t>> groups = closure_groups(graph, settled.accepted);
  const auto sum = [&](const std::vector<size_t>& group) {
    double chi2 = 0;
    for (const size_t e : group) chi2 += settled.chi2[e];
    return chi2;
  };
  double total = 0, closures = 0;
  for (const auto& group : groups) {
    total += sum(group);
    closures += static_cast<double>(group.size());
  }
  std::erase_if(groups, [&](const auto& group) {
    return sum(group) * closures <= kSuspicious * total * static_cast<double>(group.size());
  });
  std::sort(groups.begin(), groups.end(),
            [&](const auto& a, const auto& b) { return sum(a) > sum(b); });
  return groups;
}

/// False closures that agree with each other may bend a small graph until true ones are rejected in
/// their stead. The truncated cost is lower without them.
template <int D>
void try_without_groups(PoseGraph<D>& graph, Settled& settled, const OptimizeOptions& options) {
  int trials = 0;
  for (bool better = true; better;) {
    better = false;
    for (const std::vector<size_t>& group : suspicious_groups(graph, settled)) {
      if (better || ++trials > kMaxTrials) break;
      PoseGraph<D> other = graph;
      std::vector<char> accepted = settled.accepted;
      for (const size_t e : group) accepted[e] = 0;
      Settled without = settle(other, std::move(accepted), false, options);
      better = without.cost < settled.cost - kBetter && (settled.changed || !without.changed);
      if (!better) continue;
      graph.poses = std::move(other.poses);
      settled = std::move(without);
    }
  }
}

}  // namespace

template <int D>
RobustResult optimize_robustly(PoseGraph<D>& graph, const OptimizeOptions& options) {
  RobustResult result;
  if (graph.poses.size() < 2) {
    result.reason = "the graph has fewer than two poses";
    return result;
  }
  Settled settled = settle(graph, consistent_edges(graph), true, options);
  if (settled.optimized.iterations > 0) try_without_groups(graph, settled, options);
  result.optimized = settled.optimized;
  result.accepted = std::move(settled.accepted);
  result.chi2 = std::move(settled.chi2);
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    if (!graph.edges[e].closure) continue;
    ++(result.accepted[e] != 0 ? result.accepted_closures : result.rejected_closures);
  }
  result.reason = !result.optimized.usable() ? result.optimized.reason
                  : settled.changed          ? "it is not decided which closures are false"
                  : result.rejected_closures > result.accepted_closures
                      ? "more closures are rejected than accepted"
                      : "";
  return result;
}

template RobustResult optimize_robustly(PoseGraph<2>&, const OptimizeOptions&);
template RobustResult optimize_robustly(PoseGraph<3>&, const OptimizeOptions&);

}  // namespace infuse::mapping
