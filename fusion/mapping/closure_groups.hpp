#pragma once

#include <vector>

#include "fusion/mapping/pose_graph.hpp"

namespace infuse::mapping {

/// Accepted closures in groups that join the same two stretches of the trajectory: both their ends
/// are a few poses from those of another one. Indices of edges; each closure is in one group.
template <int D>
std::vector<std::vector<size_t>> closure_groups(const PoseGraph<D>& graph,
                                                const std::vector<char>& accepted);

}  // namespace infuse::mapping
