#include "fusion/mapping/optimize.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/mapping/free_poses.hpp"

namespace infuse::mapping {
namespace {

constexpr double kFirstDamping = 1e-6, kMaxDamping = 1e8;
constexpr double kMinDamping = 1e-12;  // of the diagonal, near double precision

/// Matrix that takes a perturbation (translation, rotation) in the frame of a pose to one
/// (rotation, translation) in the map frame.
PoseMatrix<2> to_map(const Pose<2>& T) {
  PoseMatrix<2> M = PoseMatrix<2>::Zero();
  M(0, 2) = 1;
  M.bottomLeftCorner<2, 2>() = T.linear();
  M(1, 2) = T.translation().y();
  M(2, 2) = -T.translation().x();
  return M;
}

PoseMatrix<3> to_map(const Pose<3>& T) {
  const geometry::Matrix6 adjoint = geometry::adjoint(T);
  PoseMatrix<3> M;
  M << adjoint.rightCols<3>(), adjoint.leftCols<3>();
  return M;
}

/// Whether a step moves no pose by more than the rounding of its numbers.
template <int D>
bool is_rounding(const Eigen::VectorXd& step, const std::vector<Pose<D>>& poses) {
  double largest = 1;
  for (const Pose<D>& pose : poses) {
    largest = std::max(largest, pose.translation().template lpNorm<Eigen::Infinity>());
  }
  return step.lpNorm<Eigen::Infinity>() <= 4 * std::numeric_limits<double>::epsilon() * largest;
}

}  // namespace

std::optional<std::string> OptimizeOptions::invalid() const {
  if (max_iterations < 1) return "max_iterations must be at least 1";
  if (!(tolerance > 0 && tolerance < 1)) return "tolerance must be above 0 and below 1";
  return std::nullopt;
}

template <int D>
double total_cost(const PoseGraph<D>& graph, Cost cost) {
  double sum = 0;
  for (const PoseEdge<D>& edge : graph.edges) {
    sum += edge_cost<D>(edge, graph.poses[edge.from], graph.poses[edge.to], cost);
  }
  return sum;
}

template <int D>
PoseGraphSolver<D>::PoseGraphSolver(const PoseGraph<D>& graph)
    : system_(graph.poses.empty() ? 0 : graph.poses.size() - 1, free_pairs(graph)) {}

template <int D>
double PoseGraphSolver<D>::linearize(const PoseGraph<D>& graph, Cost cost) {
  constexpr int kFreedom = kPoseFreedom<D>;
  system_.set_zero();
  gradient_.setZero(static_cast<Eigen::Index>(graph.poses.size() - 1) * kFreedom);
  double sum = 0;
  for (const PoseEdge<D>& edge : graph.edges) {
    const EdgeSystem<D> term =
        linearize_edge<D>(edge, graph.poses[edge.from], graph.poses[edge.to], cost);
    sum += term.cost;
    const auto part = [&](size_t pose) {
      return gradient_.segment<kFreedom>(static_cast<Eigen::Index>(pose - 1) * kFreedom);
    };
    if (edge.from != 0) {
      system_.add(edge.from - 1, edge.from - 1, term.H_from_from);
      part(edge.from) += term.g_from;
    }
    if (edge.to != 0) {
      system_.add(edge.to - 1, edge.to - 1, term.H_to_to);
      part(edge.to) += term.g_to;
    }
    if (edge.from != 0 && edge.to != 0) {
      system_.add(edge.to - 1, edge.from - 1, term.H_to_from);
    }
  }
  return sum;
}

template <int D>
OptimizeResult PoseGraphSolver<D>::optimize(PoseGraph<D>& graph, const OptimizeOptions& options) {
  constexpr int kFreedom = kPoseFreedom<D>;
  OptimizeResult result;
  if (graph.poses.size() < 2) {
    result.reason = "the graph has fewer than two poses";
    return result;
  }
  result.cost = linearize(graph, options.cost);
  result.initial_cost = result.cost;
  double damping = kFirstDamping, growth = 2;
  std::vector<Pose<D>> moved(graph.poses.size(), graph.poses[0]);
  const auto grow = [&] {
    damping *= growth;
    growth *= 2;
    return damping < kMaxDamping;
  };
  while (result.iterations < options.max_iterations) {
    ++result.iterations;
    if (!system_.factorize(damping)) {
      if (grow()) continue;
      result.reason = "the edges do not determine the poses";
      return result;
    }
    const Eigen::VectorXd step = -system_.solve(gradient_);
    if (!step.allFinite()) {
      result.reason = "the edges do not determine the poses";
      return result;
    }
    if (is_rounding<D>(step, graph.poses)) {  // as where all edges agree, and the cost is 0
      result.reason = "";
      return result;
    }
    for (size_t i = 1; i < graph.poses.size(); ++i) {
      moved[i] = perturb<D>(graph.poses[i],
                            step.segment<kFreedom>(static_cast<Eigen::Index>(i - 1) * kFreedom));
    }
    graph.poses.swap(moved);
    const double cost = total_cost(graph, options.cost);
    // With (H + damping diag H) δ = −g the model decreases by −gᵀδ and the damping's share more.
    const double predicted = -gradient_.dot(step), decrease = result.cost - cost;
    if (!(decrease > 0)) {
      graph.poses.swap(moved);
      if (predicted <= options.tolerance * result.cost || !grow()) {
        result.reason = "";
        return result;
      }
      continue;
    }
    const double gain = decrease / predicted;
    const double before = result.cost;
    result.cost = cost;
    if (decrease <= options.tolerance * before && damping < 1e-3) {
      result.reason = "";
      return result;
    }
    damping = std::max(kMinDamping, damping * std::max(0.1, 1 - std::pow(2 * gain - 1, 3)));
    growth = 2;
    linearize(graph, options.cost);
  }
  result.reason = "the optimisation has not converged";
  return result;
}

template <int D>
std::vector<PoseMatrix<D>> PoseGraphSolver<D>::covariances(const PoseGraph<D>& graph,
                                                           const std::vector<size_t>& poses) {
  constexpr int kFreedom = kPoseFreedom<D>;
  if (graph.poses.empty()) return {};
  linearize(graph, Cost::kInformation);
  if (!system_.factorize(0)) return {};
  std::vector<PoseMatrix<D>> covariances;
  for (const size_t pose : poses) {
    PoseMatrix<D> inverse = PoseMatrix<D>::Zero();
    if (pose != 0) {
      const auto row = static_cast<Eigen::Index>(pose - 1) * kFreedom;
      Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(gradient_.size(), kFreedom);
      unit.middleRows<kFreedom>(row).setIdentity();
      inverse = system_.solve(unit).template middleRows<kFreedom>(row);
      if (!inverse.allFinite()) return {};
    }
    const PoseMatrix<D> M = to_map(graph.poses[pose]);
    const PoseMatrix<D> covariance = M * inverse * M.transpose();
    covariances.push_back((covariance + covariance.transpose()) / 2);
  }
  return covariances;
}

template class PoseGraphSolver<2>;
template class PoseGraphSolver<3>;
template double total_cost(const PoseGraph<2>&, Cost);
template double total_cost(const PoseGraph<3>&, Cost);

}  // namespace infuse::mapping
