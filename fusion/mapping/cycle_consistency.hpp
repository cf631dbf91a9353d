#pragma once

#include <vector>

#include "fusion/mapping/pose_graph.hpp"

namespace infuse::mapping {

/// Which edges belong to one consistent graph: all odometry, and the closures that agree with it
/// and with each other.
///
/// A closure and the least uncertain path between its poses, through odometry and the closures
/// accepted so far, form a cycle. Its evidence is the log-likelihood ratio of "true", a normal
/// error of the cycle's covariance, and "false", a pose anywhere in the area of the graph. Closures
/// with the strongest evidence are accepted first; they shorten the paths of others, whose tests
/// become sharp. A long drive by uncertain odometry proves nothing: such closures wait. Covariances
/// are stated up to a common factor, which is estimated from the cycles and widened once, when
/// nothing more is accepted.
template <int D>
std::vector<char> consistent_edges(const PoseGraph<D>& graph);

}  // namespace infuse::mapping
