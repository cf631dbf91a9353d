#include "tests/study/mapping/false_closures.hpp"

#include "fusion/mapping/edge_cost.hpp"

namespace infuse::study {

using mapping::Pose;
using mapping::PoseEdge;
using mapping::PoseGraph;

template <int D>
void add_false_closures(PoseGraph<D>& graph, size_t count, bool groups, std::mt19937& random) {
  constexpr double kFalseChi2 = 100;  // what disagrees less with the poses is not called false
  std::vector<PoseEdge<D>> models;
  for (const PoseEdge<D>& edge : graph.edges) {
    if (edge.closure) models.push_back(edge);
  }
  const size_t poses = graph.poses.size();
  const auto below = [&](size_t n) {
    return std::uniform_int_distribution<size_t>(0, n - 1)(random);
  };
  while (count > 0) {
    const size_t size = groups ? std::min(count, 5 + below(6)) : 1;
    const size_t from = below(poses), first_to = below(poses);
    const bool backwards = groups && below(2) == 0;
    const PoseEdge<D>& model = models[below(models.size())];
    const size_t gap = from > first_to ? from - first_to : first_to - from;
    if (gap < 2 * size + 2 || from + size > poses || first_to + size > poses) continue;
    const auto to = [&](size_t k) { return first_to + (backwards ? size - 1 - k : k); };
    PoseEdge<D> edge{from, to(0), model.T_from_to, model.information, true};
    if (mapping::edge_cost<D>(edge, graph.poses[edge.from], graph.poses[edge.to],
                              mapping::Cost::kInformation) < kFalseChi2) {
      continue;
    }
    for (size_t k = 0; k < size; ++k) {
      edge.from = from + k;
      edge.to = to(k);
      edge.T_from_to = (graph.poses[from].inverse() * graph.poses[edge.from]).inverse() *
                       model.T_from_to * (graph.poses[to(0)].inverse() * graph.poses[edge.to]);
      graph.edges.push_back(edge);
    }
    count -= size;
  }
}

template void add_false_closures(PoseGraph<2>&, size_t, bool, std::mt19937&);
template void add_false_closures(PoseGraph<3>&, size_t, bool, std::mt19937&);

}  // namespace infuse::study
