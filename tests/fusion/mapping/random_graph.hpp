#pragma once

#include <random>

#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/mapping/pose_graph.hpp"

namespace infuse::mapping {

template <int D>
using Freedom = Eigen::Matrix<double, kPoseFreedom<D>, 1>;

/// T moved by ξ, (translation, rotation) in the frame of T; to first order T exp(ξ).
inline Pose<2> moved(const Pose<2>& T, const Freedom<2>& xi) {
  Pose<2> change = Pose<2>::Identity();
  change.linear() = Eigen::Rotation2Dd(xi[2]).toRotationMatrix();
  change.translation() = xi.head<2>();
  return T * change;
}

inline Pose<3> moved(const Pose<3>& T, const Freedom<3>& xi) {
  geometry::Vector6 twist;
  twist << xi.tail<3>(), xi.head<3>();
  return T * geometry::exp(twist);
}

template <int D>
Freedom<D> random_vector(std::mt19937& random, double sigma) {
  std::normal_distribution<double> normal(0, sigma);
  return Freedom<D>::NullaryExpr([&] { return normal(random); });
}

/// Poses along a walk that begins at the origin.
template <int D>
std::vector<Pose<D>> random_walk(size_t poses, std::mt19937& random) {
  std::vector<Pose<D>> walk = {Pose<D>::Identity()};
  while (walk.size() < poses) {
    Freedom<D> step = random_vector<D>(random, 0.5);
    step[0] += 1;
    walk.push_back(moved(walk.back(), step));
  }
  return walk;
}

/// An edge that measures the motion between two poses with errors of standard deviation `sigma` (m
/// and rad), and states the information of that.
template <int D>
PoseEdge<D> measured_edge(const std::vector<Pose<D>>& truth, size_t from, size_t to, double sigma,
                          std::mt19937& random) {
  PoseEdge<D> edge{from, to, truth[from].inverse() * truth[to]};
  edge.T_from_to = moved(edge.T_from_to, random_vector<D>(random, sigma));
  const double weight = sigma > 0 ? 1 / (sigma * sigma) : 1;
  edge.information *= weight;
  if (D == 3) edge.information.template bottomRightCorner<3, 3>() *= 4;  // of half the angle
  edge.closure = to != from + 1;
  return edge;
}

/// A walk with odometry and closures between random poses.
template <int D>
PoseGraph<D> random_graph(const std::vector<Pose<D>>& truth, size_t closures, double sigma,
                          std::mt19937& random) {
  PoseGraph<D> graph;
  graph.poses.assign(truth.size(), Pose<D>::Identity());
  for (size_t i = 0; i + 1 < truth.size(); ++i) {
    graph.edges.push_back(measured_edge<D>(truth, i, i + 1, sigma, random));
  }
  std::uniform_int_distribution<size_t> any(0, truth.size() - 1);
  while (closures > 0) {
    const size_t from = any(random), to = any(random);
    if (from == to || from + 1 == to || to + 1 == from) continue;
    graph.edges.push_back(measured_edge<D>(truth, from, to, sigma, random));
    --closures;
  }
  return graph;
}

}  // namespace infuse::mapping
