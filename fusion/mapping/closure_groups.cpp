#include "fusion/mapping/closure_groups.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace infuse::mapping {
namespace {

constexpr size_t kReach = 3;  // poses between the ends of neighbours (decision 17)

bool near(size_t a, size_t b) { return std::max(a, b) - std::min(a, b) <= kReach; }

/// Index of the group's first member.
size_t first_of(std::vector<size_t>& parent, size_t i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

}  // namespace

template <int D>
std::vector<std::vector<size_t>> closure_groups(const PoseGraph<D>& graph,
                                                const std::vector<char>& accepted) {
  struct Ends {
    size_t low, high, edge;
  };
  std::vector<Ends> closures;
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    const PoseEdge<D>& edge = graph.edges[e];
    if (!edge.closure || accepted[e] == 0) continue;
    closures.push_back({std::min(edge.from, edge.to), std::max(edge.from, edge.to), e});
  }
  std::sort(closures.begin(), closures.end(), [](const Ends& a, const Ends& b) {
    return std::tie(a.low, a.high, a.edge) < std::tie(b.low, b.high, b.edge);
  });
  std::vector<size_t> parent(closures.size());
  std::iota(parent.begin(), parent.end(), size_t{0});
  for (size_t i = 0; i < closures.size(); ++i) {
    for (size_t j = i + 1; j < closures.size() && near(closures[i].low, closures[j].low); ++j) {
      if (!near(closures[i].high, closures[j].high)) continue;
      const size_t a = first_of(parent, i), b = first_of(parent, j);
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  std::vector<std::vector<size_t>> members(closures.size());
  for (size_t i = 0; i < closures.size(); ++i) {
    members[first_of(parent, i)].push_back(closures[i].edge);
  }
  std::erase_if(members, [](const auto& group) { return group.empty(); });
  return members;
}

template std::vector<std::vector<size_t>> closure_groups(const PoseGraph<2>&,
                                                         const std::vector<char>&);
template std::vector<std::vector<size_t>> closure_groups(const PoseGraph<3>&,
                                                         const std::vector<char>&);

}  // namespace infuse::mapping
