#include "fusion/mapping/position_factors.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/measurement/median.hpp"
#include "fusion/geometry/plane_length.hpp"

namespace infuse::mapping {
namespace {

constexpr int kPositionPasses = 8;

Eigen::Vector3d error_of(const PositionFactor& factor, const Pose<3>& T_map_pose) {
  return T_map_pose * factor.point - factor.position;
}

/// Errors in units of the standard deviations, horizontal and vertical, the larger.
double sigmas_of(const PositionFactor& factor, const Pose<3>& T_map_pose) {
  const Eigen::Vector3d e = error_of(factor, T_map_pose).cwiseQuotient(factor.sigma);
  return std::max(e.head<2>().norm() / std::sqrt(2.0), std::abs(e.z()));
}

/// Least squares over the accepted factors: rotation about the vertical, and translation.
Pose<3> align_upright(const std::vector<Pose<3>>& poses, const std::vector<PositionFactor>& factors,
                      const std::vector<char>& accepted) {
  Eigen::Vector3d from = Eigen::Vector3d::Zero(), to = Eigen::Vector3d::Zero();
  double count = 0;
  for (size_t i = 0; i < factors.size(); ++i) {
    if (accepted[i] == 0) continue;
    from += poses[factors[i].pose] * factors[i].point;
    to += factors[i].position;
    ++count;
  }
  from /= count;
  to /= count;
  double cosine = 0, sine = 0;
  for (size_t i = 0; i < factors.size(); ++i) {
    if (accepted[i] == 0) continue;
    const Eigen::Vector3d a = poses[factors[i].pose] * factors[i].point - from;
    const Eigen::Vector3d b = factors[i].position - to;
    cosine += a.x() * b.x() + a.y() * b.y();
    sine += a.x() * b.y() - a.y() * b.x();
  }
  Pose<3> T = Pose<3>::Identity();
  const double norm = geometry::plane_length(cosine, sine);
  if (norm > 0) {
    T.linear() << cosine / norm, -sine / norm, 0, sine / norm, cosine / norm, 0, 0, 0, 1;
  }
  T.translation() = to - T.linear() * from;
  return T;
}

/// Root of the mean squared horizontal distance from the mean.
double extent_of(const std::vector<PositionFactor>& factors) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const PositionFactor& factor : factors) mean += factor.position.head<2>();
  mean /= static_cast<double>(factors.size());
  double sum = 0;
  for (const PositionFactor& factor : factors) {
    sum += (factor.position.head<2>() - mean).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(factors.size()));
}

/// Edge from the map's origin, about the present rotation of the pose.
PoseEdge<3> edge_of(const PositionFactor& factor, const Pose<3>& T_map_pose, double weight) {
  PoseEdge<3> edge;
  edge.from = 0;
  edge.to = factor.pose + 1;
  edge.closure = true;
  // With the rotation of the map, its axes are those of the information.
  edge.T_from_to.translation() = factor.position - T_map_pose.linear() * factor.point;
  edge.information.setZero();
  edge.information.diagonal().head<3>() = weight * factor.sigma.cwiseAbs2().cwiseInverse();
  return edge;
}

/// Fits once; the poses of `graph` are the start and the result.
OptimizeResult fit_once(const PoseGraph<3>& keyframes, const std::vector<PositionFactor>& factors,
                        const std::vector<char>& accepted, double weight, PoseGraph<3>& graph) {
  graph.edges.clear();
  for (PoseEdge<3> edge : keyframes.edges) {
    ++edge.from;
    ++edge.to;
    graph.edges.push_back(edge);
  }
  for (size_t i = 0; i < factors.size(); ++i) {
    if (accepted[i] != 0) {
      graph.edges.push_back(edge_of(factors[i], graph.poses[factors[i].pose + 1], weight));
    }
  }
  return PoseGraphSolver<3>(graph).optimize(graph);
}

/// Which factors the poses agree with; the limit is widened to a multiple of the median error, so
/// that a poor start rejects the worst ones only. Returns true if any changed.
bool select(const std::vector<PositionFactor>& factors, const std::vector<Pose<3>>& poses,
            size_t first, double max_sigmas, std::vector<char>& accepted) {
  std::vector<double> errors;
  for (const PositionFactor& factor : factors) {
    errors.push_back(sigmas_of(factor, poses[factor.pose + first]));
  }
  std::vector<double> sorted = errors;
  const double limit = std::max(max_sigmas, 3 * median(sorted));
  bool changed = false;
  for (size_t i = 0; i < errors.size(); ++i) {
    const char accept = errors[i] <= limit ? 1 : 0;
    changed |= accept != accepted[i];
    accepted[i] = accept;
  }
  return changed;
}

}  // namespace

std::optional<std::string> PositionOptions::invalid() const {
  if (!(sigma > 0 && vertical_factor > 0)) return "standard deviations must be positive";
  if (!(spacing > 0 && correlation > 0)) return "spacing and correlation must be positive";
  if (!(max_outlier_sigmas > 0)) return "max_outlier_sigmas must be positive";
  if (min_fixes < 3) return "min_fixes must be at least 3";
  if (!(min_extent > 0)) return "min_extent must be positive";
  if (!(min_inliers > 0 && min_inliers <= 1)) return "min_inliers must lie in 0 … 1";
  return std::nullopt;
}

PositionFit fit_positions(const PoseGraph<3>& keyframes, const std::vector<PositionFactor>& factors,
                          const PositionOptions& options) {
  PositionFit fit;
  fit.accepted.assign(factors.size(), 1);
  if (factors.size() < options.min_fixes) {
    fit.reason = factors.empty() ? "no positions" : "too few positions";
    return fit;
  }
  if (extent_of(factors) < options.min_extent) {
    fit.reason = "the positions are too close together to give a heading";
    return fit;
  }
  const double weight = std::min(1.0, options.spacing / options.correlation);
  std::vector<Pose<3>> poses;
  for (int pass = 0; pass < kPositionPasses; ++pass) {
    const Pose<3> T = align_upright(keyframes.poses, factors, fit.accepted);
    poses.clear();
    for (const Pose<3>& pose : keyframes.poses) poses.push_back(T * pose);
    if (!select(factors, poses, 0, options.max_outlier_sigmas, fit.accepted)) break;
  }
  fit.graph.poses.assign(1, Pose<3>::Identity());
  fit.graph.poses.insert(fit.graph.poses.end(), poses.begin(), poses.end());
  for (int pass = 0; pass < kPositionPasses; ++pass) {
    fit.optimized = fit_once(keyframes, factors, fit.accepted, weight, fit.graph);
    if (!fit.optimized.usable()) {
      fit.reason = fit.optimized.reason;
      return fit;
    }
    if (!select(factors, fit.graph.poses, 1, options.max_outlier_sigmas, fit.accepted)) break;
  }
  double sum = 0, count = 0;
  for (size_t i = 0; i < factors.size(); ++i) {
    if (fit.accepted[i] == 0) continue;
    sum += error_of(factors[i], fit.graph.poses[factors[i].pose + 1]).head<2>().squaredNorm();
    ++count;
  }
  fit.rms = std::sqrt(sum / std::max(count, 1.0));
  fit.reason = count < options.min_inliers * static_cast<double>(factors.size())
                   ? "most positions contradict the odometry"
                   : "";
  return fit;
}

}  // namespace infuse::mapping
