#include "fusion/mapping/pose_graph.hpp"

#include <deque>

#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::mapping {
namespace {

/// Visits every edge that leads to a new pose, odometry first: visit(edge, forward).
/// Returns which poses were reached.
template <int D, class Visit>
std::vector<bool> walk(const PoseGraph<D>& graph, Visit visit) {
  std::vector<std::vector<size_t>> edges_of(graph.poses.size());
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    edges_of[graph.edges[e].from].push_back(e);
    edges_of[graph.edges[e].to].push_back(e);
  }
  struct Step {
    size_t pose, edge;
  };
  std::vector<bool> reached(graph.poses.size());
  std::deque<Step> steps;
  const auto leave = [&](size_t pose) {
    reached[pose] = true;
    for (const size_t e : edges_of[pose]) {
      const PoseEdge<D>& edge = graph.edges[e];
      const size_t other = edge.from == pose ? edge.to : edge.from;
      if (edge.closure) {
        steps.push_back({other, e});
      } else {
        steps.push_front({other, e});
      }
    }
  };
  if (!graph.poses.empty()) leave(0);
  while (!steps.empty()) {
    const Step step = steps.front();
    steps.pop_front();
    if (reached[step.pose]) continue;
    const PoseEdge<D>& edge = graph.edges[step.edge];
    visit(edge, edge.to == step.pose);
    leave(step.pose);
  }
  return reached;
}

}  // namespace

template <int D>
size_t first_unconnected(const PoseGraph<D>& graph) {
  const std::vector<bool> reached = walk(graph, [](const PoseEdge<D>&, bool) {});
  return static_cast<size_t>(std::find(reached.begin(), reached.end(), false) - reached.begin());
}

template <int D>
void compose_odometry(PoseGraph<D>& graph) {
  walk(graph, [&](const PoseEdge<D>& edge, bool forward) {
    if (forward) {
      graph.poses[edge.to] = graph.poses[edge.from] * edge.T_from_to;
    } else {
      graph.poses[edge.from] = graph.poses[edge.to] * edge.T_from_to.inverse();
    }
  });
}

PoseMatrix<3> edge_information(const Pose<3>& T_from_to, const PoseMatrix<3>& covariance) {
  // exp(ξ) T = T exp(adjoint(T⁻¹) ξ), a translation and a rotation in the frame at `to`.
  const geometry::Matrix6 at_to =
      geometry::transform_covariance(T_from_to.inverse(), covariance).inverse();
  PoseMatrix<3> information;
  information << at_to.bottomRightCorner<3, 3>(), 2 * at_to.bottomLeftCorner<3, 3>(),
      2 * at_to.topRightCorner<3, 3>(), 4 * at_to.topLeftCorner<3, 3>();
  return information;
}

template size_t first_unconnected(const PoseGraph<2>&);
template size_t first_unconnected(const PoseGraph<3>&);
template void compose_odometry(PoseGraph<2>&);
template void compose_odometry(PoseGraph<3>&);

}  // namespace infuse::mapping
