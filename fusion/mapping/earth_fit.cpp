#include "fusion/mapping/earth_fit.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/measurement/median.hpp"
#include "fusion/geometry/plane_length.hpp"

namespace infuse::mapping {
namespace {

constexpr int kPasses = 8;      // bounds time
constexpr double kHeld = 1e-3;  // m and rad, standard deviation of what is held

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
PoseEdge<3> position_edge(const PositionFactor& factor, const Pose<3>& T_map_pose, double weight) {
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

/// Edge from the map's origin to the pose as it would stand on level ground with its present
/// heading; it says nothing of place and heading.
PoseEdge<3> level_edge(size_t to, const Pose<3>& T_map_pose, double weight,
                       const EarthFitOptions& options) {
  PoseEdge<3> edge;
  edge.from = 0;
  edge.to = to;
  edge.closure = true;
  const Eigen::Vector3d up = T_map_pose.linear().col(2);
  edge.T_from_to = T_map_pose;
  edge.T_from_to.linear() =
      Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ()) * T_map_pose.linear();
  edge.information.setZero();
  // q is half of a rotation.
  edge.information(3, 3) = weight * 4 / (options.roll_sigma * options.roll_sigma);
  edge.information(4, 4) = weight * 4 / (options.pitch_sigma * options.pitch_sigma);
  return edge;
}

/// Without positions: the first keyframe keeps its place and heading.
PoseEdge<3> first_edge(const Pose<3>& T_map_first, const EarthFitOptions& options) {
  PoseEdge<3> edge = level_edge(1, T_map_first, 1, options);
  edge.closure = false;
  edge.information.diagonal().head<3>().setConstant(1 / (kHeld * kHeld));
  edge.information(5, 5) = 4 / (kHeld * kHeld);
  return edge;
}

/// Metres from the keyframe before, by the poses.
double step_to(const PoseGraph<3>& keyframes, size_t k) {
  return (keyframes.poses[k].translation() - keyframes.poses[k - 1].translation()).norm();
}

/// Fits once about the present poses of `graph`, which are the start and the result.
void fit_once(const PoseGraph<3>& keyframes, const std::vector<PositionFactor>& factors,
              const EarthFitOptions& options, EarthFit& fit) {
  PoseGraph<3>& graph = fit.graph;
  graph.edges.clear();
  for (PoseEdge<3> edge : keyframes.edges) {
    ++edge.from;
    ++edge.to;
    graph.edges.push_back(edge);
  }
  // With positions, keyframe 0 is left without: an edge between successive poses of a graph is
  // taken for odometry.
  if (!fit.position_reason.empty()) graph.edges.push_back(first_edge(graph.poses[1], options));
  for (size_t k = 1; k < keyframes.poses.size(); ++k) {
    const double weight =
        k == 1 ? 1.0 : std::min(1.0, step_to(keyframes, k) / options.slope_correlation);
    graph.edges.push_back(level_edge(k + 1, graph.poses[k + 1], weight, options));
  }
  const double weight = std::min(1.0, options.spacing / options.correlation);
  for (size_t i = 0; i < factors.size(); ++i) {
    if (fit.accepted[i] != 0) {
      const Pose<3>& T_map_pose = graph.poses[factors[i].pose + 1];
      graph.edges.push_back(position_edge(factors[i], T_map_pose, weight));
    }
  }
  fit.optimized = PoseGraphSolver<3>(graph).optimize(graph);
}

/// Standard deviation of the vertical, rad: the largest of the first, middle and last keyframe.
double tilt_sigma_of(const PoseGraph<3>& graph) {
  PoseGraphSolver<3> solver(graph);
  const size_t last = graph.poses.size() - 1;
  double variance = 0;
  for (const PoseMatrix<3>& covariance : solver.covariances(graph, {1, (1 + last) / 2, last})) {
    const Eigen::Matrix2d tilt = covariance.topLeftCorner<2, 2>();
    variance = std::max(variance, tilt.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff());
  }
  return std::sqrt(variance);
}

/// Why positions cannot georeference a map, or an empty text.
std::string why_not_used(const std::vector<PositionFactor>& positions,
                         const EarthFitOptions& options) {
  if (positions.empty()) return "no positions";
  if (positions.size() < options.min_fixes) return "too few positions";
  if (extent_of(positions) < options.min_extent) {
    return "the positions are too close together to give a heading";
  }
  return "";
}

/// Which factors the poses agree with; the limit is widened to a multiple of the median error, so
/// that a poor start rejects the worst ones only; poses[0] is the map's origin. Returns true if any
/// changed.
bool select(const std::vector<PositionFactor>& factors, const std::vector<Pose<3>>& poses,
            double max_sigmas, std::vector<char>& accepted) {
  std::vector<double> errors;
  for (const PositionFactor& factor : factors) {
    errors.push_back(sigmas_of(factor, poses[factor.pose + 1]));
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

void set_poses(const Pose<3>& T, const std::vector<Pose<3>>& poses, PoseGraph<3>& graph) {
  graph.poses.assign(1, Pose<3>::Identity());
  for (const Pose<3>& pose : poses) graph.poses.push_back(T * pose);
}

/// Fits to the positions without those that contradict.
void fit_positions(const PoseGraph<3>& keyframes, const std::vector<PositionFactor>& positions,
                   const EarthFitOptions& options, EarthFit& fit) {
  fit.accepted.assign(positions.size(), 1);
  const auto changes = [&] {
    return select(positions, fit.graph.poses, options.max_outlier_sigmas, fit.accepted);
  };
  for (int pass = 0; pass < kPasses; ++pass) {
    set_poses(align_upright(keyframes.poses, positions, fit.accepted), keyframes.poses, fit.graph);
    if (!changes()) break;
  }
  for (int pass = 0; pass < kPasses; ++pass) {
    fit_once(keyframes, positions, options, fit);
    if (!fit.usable() || !changes()) break;
  }
  double sum = 0, count = 0;
  for (size_t i = 0; i < positions.size(); ++i) {
    if (fit.accepted[i] == 0) continue;
    sum += error_of(positions[i], fit.graph.poses[positions[i].pose + 1]).head<2>().squaredNorm();
    ++count;
  }
  fit.rms = std::sqrt(sum / std::max(count, 1.0));
  if (count < options.min_inliers * static_cast<double>(positions.size())) {
    fit.position_reason = "most positions contradict the odometry";
  }
}

/// Makes the poses upright by the roads' slope alone.
void fit_slopes(const PoseGraph<3>& keyframes, const EarthFitOptions& options, EarthFit& fit) {
  set_poses(Pose<3>::Identity(), keyframes.poses, fit.graph);
  // The first pass may turn them far, and the second is about where it led.
  for (int pass = 0; pass < 2; ++pass) {
    fit_once(keyframes, {}, options, fit);
    if (!fit.usable()) break;
  }
}

}  // namespace

std::optional<std::string> EarthFitOptions::invalid() const {
  if (!(sigma > 0 && vertical_factor > 0)) return "standard deviations must be positive";
  if (!(roll_sigma > 0 && pitch_sigma > 0)) return "slopes must be positive";
  if (!(spacing > 0 && correlation > 0 && slope_correlation > 0)) {
    return "spacing and correlation must be positive";
  }
  if (!(max_outlier_sigmas > 0)) return "max_outlier_sigmas must be positive";
  if (min_fixes < 3) return "min_fixes must be at least 3";
  if (!(min_extent > 0)) return "min_extent must be positive";
  if (!(min_inliers > 0 && min_inliers <= 1)) return "min_inliers must be between 0 and 1";
  return std::nullopt;
}

EarthFit fit_to_earth(const PoseGraph<3>& keyframes, const std::vector<PositionFactor>& positions,
                      const EarthFitOptions& options) {
  EarthFit fit;
  fit.position_reason = why_not_used(positions, options);
  if (fit.position_reason.empty()) fit_positions(keyframes, positions, options, fit);
  if (!fit.position_reason.empty()) {
    fit.accepted.assign(positions.size(), 0);
    fit.rms = 0;
    fit_slopes(keyframes, options, fit);
  }
  if (fit.usable()) fit.tilt_sigma = tilt_sigma_of(fit.graph);
  return fit;
}

}  // namespace infuse::mapping
