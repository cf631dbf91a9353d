#pragma once

#include <utility>
#include <vector>

#include "fusion/mapping/pose_graph.hpp"

namespace infuse::mapping {

/// Pairs of indices of poses that an edge joins, less one: pose 0 is held, so that the others are
/// the unknowns.
template <int D>
std::vector<std::pair<size_t, size_t>> free_pairs(const PoseGraph<D>& graph) {
  std::vector<std::pair<size_t, size_t>> pairs;
  for (const PoseEdge<D>& edge : graph.edges) {
    if (edge.from != 0 && edge.to != 0) pairs.emplace_back(edge.from - 1, edge.to - 1);
  }
  return pairs;
}

}  // namespace infuse::mapping
