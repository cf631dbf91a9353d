#include "fusion/registration/visual/information_alignment.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "fusion/calibration/ascent.hpp"
#include "fusion/registration/lengths.hpp"
#include "fusion/registration/rigid_consensus.hpp"

namespace infuse::registration {
namespace {

using geometry::Vector6;

constexpr int kFits = 4;  // least-squares fits, each with the correspondences of the one before
constexpr size_t kMinClusters = 8;  // fewer cells say too little about six parameters

/// A pose and the mutual information there.
struct Candidate {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  double value = 0;
  bool converged = false;
};

class Aligner {
 public:
  Aligner(const Codebook& codebook, const CodewordCloud& target, const CodewordCloud& source,
          const InformationAlignmentOptions& options)
      : source_(source),
        target_(target),
        options_(options),
        information_(codebook, target, options.shrinkage,
                     0.5 * static_cast<double>(target.size() + source.size())) {}

  double evaluate(const Eigen::Isometry3d& T) { return information_.evaluate(source_, T); }
  void set_radius(double radius) {
    radius_ = radius;
    information_.set_radius(radius);
  }

  /// Nelder–Mead from a pose, with steps of the size of the radius.
  Candidate climb(const Eigen::Isometry3d& T) {
    const auto pose = [&](const Vector6& d) -> Eigen::Isometry3d {
      Vector6 twist = radius_ * d;
      twist.head<3>() /= kLever;
      return T * geometry::exp(twist);
    };
    const auto value = [&](const Vector6& d, Vector6*) { return evaluate(pose(d)); };
    const auto end = calibration::ascend_simplex(value, {.max_iterations = 600, .tolerance = 0.01});
    return {pose(end.d), end.value, end.converged};
  }

  /// The best planar poses, at least two steps of the grid apart.
  std::vector<Candidate> search_grid() {
    const double step = radius_, turn = radius_ / kLever;
    const int steps = static_cast<int>(options_.max_distance / step);
    const int turns = static_cast<int>(options_.max_heading / turn);
    std::vector<Candidate> grid;
    for (int k = -turns; k <= turns; ++k) {
      Candidate at;
      at.T.linear() = geometry::rotation_exp({0, 0, k * turn});
      for (int i = -steps; i <= steps; ++i) {
        for (int j = -steps; j <= steps; ++j) {
          if (i * i + j * j > steps * steps) continue;
          at.T.translation() = Eigen::Vector3d(i * step, j * step, 0);
          at.value = evaluate(at.T);
          grid.push_back(at);
        }
      }
    }
    std::stable_sort(grid.begin(), grid.end(),
                     [](const Candidate& a, const Candidate& b) { return a.value > b.value; });
    std::vector<Candidate> best;
    for (const Candidate& c : grid) {
      if (best.size() >= static_cast<size_t>(options_.candidates)) break;
      if (std::none_of(best.begin(), best.end(),
                       [&](const Candidate& b) { return same(b.T, c.T, 2 * step); })) {
        best.push_back(c);
      }
    }
    return best;
  }

  /// Corresponding points with equal codewords at a pose.
  Correspondences equal_codewords(const Eigen::Isometry3d& T) {
    evaluate(T);
    Correspondences equal;
    for (const auto& [q, p] : information_.correspondences()) {
      if (target_.words[q] != source_.words[p]) continue;
      equal.target.push_back(target_.points.col(q).cast<double>());
      equal.source.push_back(source_.points.col(p).cast<double>());
    }
    return equal;
  }

  /// True if two poses differ by less than `distance` (m), rotations at kLever.
  static bool same(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double distance) {
    const Vector6 d = geometry::log(a.inverse() * b);
    return d.head<3>().norm() * kLever < distance && d.tail<3>().norm() < distance;
  }

 private:
  const CodewordCloud &source_, &target_;
  const InformationAlignmentOptions& options_;
  CodewordInformation information_;
  double radius_ = 1;
};

/// Left perturbation's effect on a point of the target's frame.
Eigen::Matrix<double, 3, 6> jacobian(const Eigen::Vector3d& point) {
  Eigen::Matrix<double, 3, 6> J;
  J << -geometry::skew(point), Eigen::Matrix3d::Identity();
  return J;
}

/// Normal equations of the keypoints in one cell.
struct Cluster {
  geometry::Matrix6 A = geometry::Matrix6::Zero();  // Σ JᵀJ
  Vector6 gradient = Vector6::Zero();               // Σ Jᵀ r
};

/// Covariance of the least-squares fit by the jackknife: from how the pose moves when the keypoints
/// of one cell are left out. Keypoints on one object err together, so they are left out together.
/// Zero if too few cells determine the pose.
geometry::Matrix6 fit_covariance(const Correspondences& equal, const Eigen::Isometry3d& T) {
  Cluster all;
  std::map<std::array<int, 3>, Cluster> clusters;
  for (size_t i = 0; i < equal.size(); ++i) {
    const Eigen::Vector3d moved = T * equal.source[i];
    const Eigen::Matrix<double, 3, 6> J = jacobian(moved);
    const Eigen::Array3i cell = (equal.source[i] / kClusterSize).array().floor().cast<int>();
    for (Cluster* c : {&all, &clusters[{cell.x(), cell.y(), cell.z()}]}) {
      c->A += J.transpose() * J;
      c->gradient += J.transpose() * (equal.target[i] - moved);
    }
  }
  geometry::Matrix6 covariance = geometry::Matrix6::Zero();
  if (clusters.size() < kMinClusters) return covariance;
  for (const auto& [cell, c] : clusters) {
    const Vector6 moved = (all.A - c.A).ldlt().solve(all.gradient - c.gradient);
    covariance += moved * moved.transpose();
  }
  const auto n = static_cast<double>(clusters.size());
  return (n - 1) / n * covariance + kRangeNoise * kRangeNoise * all.A.inverse();
}

}  // namespace

std::optional<std::string> InformationAlignmentOptions::invalid() const {
  if (!(fine_radius > 0 && fine_radius <= coarse_radius && coarse_radius <= 100)) {
    return "the radii must be between 0 and 100 m, the fine one not above the coarse one";
  }
  if (!(max_distance >= 0 && max_distance <= 100 * coarse_radius)) {
    return "max_distance must be between 0 and 100 coarse radii";
  }
  if (!(max_heading >= 0 && max_heading <= 3.2)) return "max_heading must be between 0 and 3.2 rad";
  if (candidates < 1 || candidates > 1000) return "candidates must be between 1 and 1000";
  if (!(max_runner_up > 0 && max_runner_up <= 1)) return "max_runner_up must be between 0 and 1";
  return std::nullopt;
}

RegistrationResult align_by_information(const Codebook& codebook, const CodewordCloud& target,
                                        const CodewordCloud& source,
                                        const InformationAlignmentOptions& options) {
  RegistrationResult result;
  result.points = source.size();
  if (std::min(target.size(), source.size()) < std::max<size_t>(options.min_codewords, 1)) {
    result.reason = "a scan has too few codewords";
    return result;
  }
  Aligner aligner(codebook, target, source, options);
  std::vector<Candidate> candidates(1);
  aligner.set_radius(options.coarse_radius);
  if (options.optimizer == InformationOptimizer::kSearch) candidates = aligner.search_grid();
  for (double radius = options.coarse_radius;; radius = std::max(radius / 2, options.fine_radius)) {
    aligner.set_radius(radius);
    for (Candidate& c : candidates) c = aligner.climb(c.T);
    if (radius <= options.fine_radius) break;
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.value > b.value; });
  const Candidate& best = candidates.front();
  double runner_up = 0;
  for (const Candidate& c : candidates) {
    if (!Aligner::same(best.T, c.T, options.coarse_radius))
      runner_up = std::max(runner_up, c.value);
  }
  result.T_target_source = best.T;
  result.converged = best.converged;
  result.reason = best.converged ? "" : "the optimiser did not converge";
  if (runner_up > options.max_runner_up * best.value) {
    result.reason = "another pose explains the codewords nearly as well";
  }
  Correspondences equal;
  for (int i = 0; i < kFits; ++i) {
    equal = aligner.equal_codewords(result.T_target_source);
    result.inliers = equal.size();
    if (equal.size() < std::max<size_t>(options.min_correspondences, 3)) {
      result.reason = "too few codewords correspond: the scans may not overlap";
      return result;
    }
    std::vector<uint32_t> all(equal.size());
    std::iota(all.begin(), all.end(), 0U);
    result.T_target_source = fit_rigid(equal, all);
  }
  result.covariance = fit_covariance(equal, result.T_target_source);
  const Eigen::LLT<geometry::Matrix6> factor(result.covariance);
  if (factor.info() != Eigen::Success) {
    result.reason = "the corresponding codewords lie too close together";
    return result;
  }
  result.information = factor.solve(geometry::Matrix6::Identity());
  return result;
}

}  // namespace infuse::registration
