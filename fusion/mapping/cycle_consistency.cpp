#include "fusion/mapping/cycle_consistency.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <queue>

#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/geometry/symmetric_eigen.hpp"
#include "fusion/mapping/chi2.hpp"

namespace infuse::mapping {
namespace {

constexpr double kMinEvidence = 4.6;  // nats: one false closure in a hundred has as much by chance
constexpr double kHopeless = -20;  // nats: evidence that few acceptances will change (decision 17)
// Of the covariances, once, when nothing more is accepted (decision 14). Widened further, chance
// makes false closures as plausible as true ones: on graphs of spheres and tori half of them were
// accepted.
constexpr double kWidening = 2;
constexpr double kLeverInSteps =
    20;  // lever of a rotation's error, in steps of the odometry; decision 17

template <int D>
using Twist = Eigen::Matrix<double, kPoseFreedom<D>, 1>;

/// Adjoint in the order (translation, rotation): T exp(δ) = exp(adjoint δ) T.
PoseMatrix<2> pose_adjoint(const Pose<2>& T) {
  PoseMatrix<2> A = PoseMatrix<2>::Identity();
  A.topLeftCorner<2, 2>() = T.linear();
  A(0, 2) = T.translation().y();
  A(1, 2) = -T.translation().x();
  return A;
}

PoseMatrix<3> pose_adjoint(const Pose<3>& T) {
  const geometry::Matrix6 A = geometry::adjoint(T);
  PoseMatrix<3> swapped;
  swapped << A.bottomRightCorner<3, 3>(), A.bottomLeftCorner<3, 3>(), A.topRightCorner<3, 3>(),
      A.topLeftCorner<3, 3>();
  return swapped;
}

template <int D>
PoseMatrix<D> carried(const Pose<D>& T_a_b, const PoseMatrix<D>& covariance_b) {
  const PoseMatrix<D> A = pose_adjoint(T_a_b);
  return A * covariance_b * A.transpose();
}

/// Translation and rotation vector of an error.
Twist<2> error_of(const Pose<2>& T) {
  return {T.translation().x(), T.translation().y(), std::atan2(T(1, 0), T(0, 0))};
}

Twist<3> error_of(const Pose<3>& T) {
  Twist<3> error;
  error << T.translation(), geometry::rotation_log(T.linear());
  return error;
}

/// Covariance of an edge in the frame at `to`, (translation, rotation), m and rad.
template <int D>
PoseMatrix<D> edge_covariance(const PoseMatrix<D>& information) {
  const auto eigen = geometry::symmetric_eigen<kPoseFreedom<D>>(information);
  const Twist<D> values = eigen.values.cwiseMax(1e-12 * std::max(eigen.values.maxCoeff(), 1e-12));
  PoseMatrix<D> covariance =
      eigen.vectors * values.cwiseInverse().asDiagonal() * eigen.vectors.transpose();
  if constexpr (D == 3) {  // of half the angle
    covariance.template bottomRows<3>() *= 2;
    covariance.template rightCols<3>() *= 2;
  }
  return covariance;
}

/// A closure with the path between its poses.
struct Cycle {
  double distance = 0;  // length of the path, m² of uncertainty
  double chi2 = 0, log_determinant = 0;
  bool closed = false;  // there is a path
};

/// Tests closures against odometry and accepted closures.
template <int D>
class CycleTest {
 public:
  explicit CycleTest(const PoseGraph<D>& graph)
      : graph_(graph),
        edges_of_(graph.poses.size()),
        distance_(graph.poses.size()),
        by_(graph.poses.size()),
        seen_(graph.poses.size(), 0) {
    double length = 0, steps = 0;
    for (const PoseEdge<D>& edge : graph.edges) {
      covariances_.push_back(edge_covariance<D>(edge.information));
      if (edge.closure) continue;
      length += edge.T_from_to.translation().norm();
      ++steps;
    }
    const double lever = kLeverInSteps * length / std::max(steps, 1.0);
    constexpr int kAngles = kPoseFreedom<D> - D;
    for (const PoseMatrix<D>& covariance : covariances_) {
      uncertainties_.push_back(
          covariance.template topLeftCorner<D, D>().trace() +
          lever * lever * covariance.template bottomRightCorner<kAngles, kAngles>().trace());
    }
  }

  /// Lets paths go along an edge.
  void accept(size_t edge) {
    edges_of_[graph_.edges[edge].from].push_back(edge);
    edges_of_[graph_.edges[edge].to].push_back(edge);
  }

  /// Tests a closure again: `before` is what the last test gave.
  Cycle test(size_t closure, const Cycle& before) {
    const PoseEdge<D>& edge = graph_.edges[closure];
    if (!find_path(edge.from, edge.to)) return {};
    const double distance = distance_[edge.to];
    if (before.closed && distance == before.distance) return before;
    std::vector<size_t> path;
    for (size_t pose = edge.to; pose != edge.from; pose = other_end(path.back(), pose)) {
      path.push_back(by_[pose]);
    }
    Pose<D> T_from_pose = Pose<D>::Identity();
    PoseMatrix<D> covariance = PoseMatrix<D>::Zero();  // in the frame of the pose
    size_t pose = edge.from;
    for (auto e = path.rbegin(); e != path.rend(); ++e) {
      const PoseEdge<D>& step = graph_.edges[*e];
      const bool forward = step.from == pose;
      const Pose<D> T = forward ? step.T_from_to : step.T_from_to.inverse();
      const PoseMatrix<D> added =
          forward ? covariances_[*e] : carried<D>(step.T_from_to, covariances_[*e]);
      covariance = carried<D>(T.inverse(), covariance) + added;
      T_from_pose = T_from_pose * T;
      pose = other_end(*e, pose);
    }
    covariance += covariances_[closure];
    const Twist<D> error = error_of(Pose<D>(edge.T_from_to.inverse() * T_from_pose));
    const Eigen::LDLT<PoseMatrix<D>> factor(covariance);
    return {distance, error.dot(factor.solve(error)), factor.vectorD().array().log().sum(), true};
  }

 private:
  size_t other_end(size_t edge, size_t pose) const {
    return graph_.edges[edge].from == pose ? graph_.edges[edge].to : graph_.edges[edge].from;
  }

  /// Dijkstra's least uncertain path; `by_` holds the edge by which a pose is reached.
  bool find_path(size_t from, size_t to) {
    using Reached = std::pair<double, size_t>;
    std::priority_queue<Reached, std::vector<Reached>, std::greater<>> queue;
    ++search_;
    seen_[from] = search_;
    distance_[from] = 0;
    queue.emplace(0, from);
    while (!queue.empty()) {
      const auto [distance, pose] = queue.top();
      queue.pop();
      if (pose == to) return true;
      if (distance > distance_[pose]) continue;
      for (const size_t edge : edges_of_[pose]) {
        const size_t next = other_end(edge, pose);
        const double further = distance + uncertainties_[edge];
        if (seen_[next] == search_ && further >= distance_[next]) continue;
        seen_[next] = search_;
        distance_[next] = further;
        by_[next] = edge;
        queue.emplace(further, next);
      }
    }
    return false;
  }

  const PoseGraph<D>& graph_;
  std::vector<PoseMatrix<D>> covariances_;  // of the edges
  std::vector<double> uncertainties_;       // of the edges, m²
  std::vector<std::vector<size_t>> edges_of_;
  std::vector<double> distance_;
  std::vector<size_t> by_;
  std::vector<size_t> seen_;  // in which search a pose was reached
  size_t search_ = 0;
};

/// Logarithm of the volume of poses among which a false closure may lie: the cube about the
/// trajectory of the odometry, all rotations.
template <int D>
double log_volume(PoseGraph<D> graph) {
  compose_odometry(graph);
  Eigen::Matrix<double, D, 1> low = graph.poses[0].translation(), high = low;
  for (const Pose<D>& pose : graph.poses) {
    low = low.cwiseMin(pose.translation());
    high = high.cwiseMax(pose.translation());
  }
  constexpr double kPi = std::numbers::pi;
  return D * std::log((high - low).norm()) + std::log(D == 2 ? 2 * kPi : 8 * kPi * kPi);
}

template <int D>
std::vector<char> find_consistent(const PoseGraph<D>& graph) {
  CycleTest<D> test(graph);
  std::vector<char> accepted(graph.edges.size(), 0);
  std::vector<size_t> waiting;
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    if (graph.edges[e].closure) {
      waiting.push_back(e);
    } else {
      accepted[e] = 1;
      test.accept(e);
    }
  }
  if (waiting.empty()) return accepted;

  std::vector<Cycle> cycles(graph.edges.size());
  std::vector<double> chi2;
  for (const size_t e : waiting) {
    cycles[e] = test.test(e, cycles[e]);
    if (cycles[e].closed) chi2.push_back(cycles[e].chi2);
  }
  double scale = chi2_scale<D>(chi2);
  const double volume = log_volume(graph);
  const auto evidence = [&](size_t e) {
    if (!cycles[e].closed) return 2 * kHopeless;
    return volume - (cycles[e].chi2 / scale + cycles[e].log_determinant +
                     kPoseFreedom<D> * std::log(2 * std::numbers::pi * scale)) /
                        2;
  };
  bool all_tested = true;
  bool widened = false;
  while (!waiting.empty()) {
    std::vector<std::pair<double, size_t>> strong;
    for (const size_t e : waiting) {
      const double nats = evidence(e);
      if (nats > kMinEvidence) strong.emplace_back(nats, e);
    }
    if (strong.empty() && all_tested) {
      if (widened) break;
      widened = true;
      scale *= kWidening;
      continue;
    }
    std::sort(strong.begin(), strong.end(), std::greater<>());
    strong.resize((strong.size() + 1) / 2);
    for (const auto& [nats, e] : strong) {
      accepted[e] = 1;
      test.accept(e);
    }
    std::erase_if(waiting, [&](size_t e) { return accepted[e] != 0; });
    // What is hopeless is tested again only where nothing else is accepted.
    all_tested = strong.empty();
    for (const size_t e : waiting) {
      if (all_tested || evidence(e) > kHopeless) cycles[e] = test.test(e, cycles[e]);
    }
  }
  return accepted;
}

}  // namespace

template <int D>
std::vector<char> consistent_edges(const PoseGraph<D>& graph) {
  return find_consistent(graph);
}

template std::vector<char> consistent_edges(const PoseGraph<2>&);
template std::vector<char> consistent_edges(const PoseGraph<3>&);

}  // namespace infuse::mapping
