#include "fusion/registration/rigid_consensus.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "fusion/geometry/symmetric_eigen.hpp"

namespace infuse::registration {
namespace {

using Triple = std::array<uint32_t, 3>;

/// True if the poses are one hypothesis. Angles are compared by the trace, without trigonometric
/// functions.
bool same_hypothesis(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double min_trace,
                     double distance) {
  return (a.translation() - b.translation()).norm() < distance &&
         (a.linear().transpose() * b.linear()).trace() > min_trace;
}

/// Draws triples, counts inliers, keeps the best distinct poses.
class Search {
 public:
  Search(const Correspondences& correspondences, const RigidConsensusOptions& options)
      : points_(correspondences),
        options_(options),
        min_trace_(1 + 2 * std::cos(options.distinct_rotation)),
        random_(options.seed) {}

  void draw() {
    const auto count = static_cast<uint64_t>(points_.size());
    Triple triple{};
    for (uint32_t& member : triple) member = static_cast<uint32_t>(random_() % count);
    if (!sides_agree(triple[0], triple[1]) || !sides_agree(triple[0], triple[2]) ||
        !sides_agree(triple[1], triple[2])) {
      return;
    }
    const Eigen::Vector3d a = points_.source[triple[1]] - points_.source[triple[0]];
    const Eigen::Vector3d b = points_.source[triple[2]] - points_.source[triple[0]];
    // Three points on a line do not determine a rotation.
    if (a.cross(b).squaredNorm() < 0.01 * a.squaredNorm() * b.squaredNorm()) return;
    consider(fit_rigid(points_, triple));
  }

  size_t best_count() const { return best_.empty() ? 0 : best_.front().count; }

  /// The hypotheses after a fit to their inliers.
  std::vector<RigidHypothesis> finish() {
    std::vector<RigidHypothesis> out;
    for (const Candidate& candidate : best_) {
      RigidHypothesis hypothesis{candidate.T_target_source, inliers(candidate.T_target_source)};
      for (int step = 0; step < 5; ++step) {
        const Eigen::Isometry3d fitted = fit_rigid(points_, hypothesis.inliers);
        std::vector<uint32_t> members = inliers(fitted);
        if (members.size() < hypothesis.inliers.size()) break;
        hypothesis = {fitted, std::move(members)};
      }
      const bool known = std::any_of(out.begin(), out.end(), [&](const RigidHypothesis& other) {
        return same(other.T_target_source, hypothesis.T_target_source);
      });
      if (!known) out.push_back(std::move(hypothesis));
    }
    std::stable_sort(out.begin(), out.end(), [](const auto& a, const auto& b) {
      return a.inliers.size() > b.inliers.size();
    });
    return out;
  }

 private:
  struct Candidate {
    Eigen::Isometry3d T_target_source;
    size_t count;
  };

  bool same(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) const {
    return same_hypothesis(a, b, min_trace_, options_.distinct_translation);
  }

  bool sides_agree(uint32_t i, uint32_t k) const {
    const double source = (points_.source[i] - points_.source[k]).norm();
    const double target = (points_.target[i] - points_.target[k]).norm();
    return std::min(source, target) >= options_.min_side &&
           std::abs(source - target) <= 2 * options_.inlier_distance;
  }

  bool agrees(const Eigen::Isometry3d& T, size_t i) const {
    return (T * points_.source[i] - points_.target[i]).squaredNorm() <=
           options_.inlier_distance * options_.inlier_distance;
  }

  std::vector<uint32_t> inliers(const Eigen::Isometry3d& T) const {
    std::vector<uint32_t> members;
    for (size_t i = 0; i < points_.size(); ++i) {
      if (agrees(T, i)) members.push_back(static_cast<uint32_t>(i));
    }
    return members;
  }

  void consider(const Eigen::Isometry3d& T) {
    size_t count = 0;
    for (size_t i = 0; i < points_.size(); ++i) count += agrees(T, i) ? 1 : 0;
    const bool full = best_.size() == options_.hypotheses;
    if (count < options_.min_inliers || (full && count <= best_.back().count)) return;
    const auto known = std::find_if(best_.begin(), best_.end(), [&](const Candidate& other) {
      return same(other.T_target_source, T);
    });
    if (known != best_.end()) {
      if (count <= known->count) return;
      *known = {T, count};
    } else if (full) {
      best_.back() = {T, count};
    } else {
      best_.push_back({T, count});
    }
    std::stable_sort(best_.begin(), best_.end(),
                     [](const Candidate& a, const Candidate& b) { return a.count > b.count; });
  }

  const Correspondences& points_;
  const RigidConsensusOptions& options_;
  double min_trace_;
  std::mt19937_64 random_;
  std::vector<Candidate> best_;  // most inliers first
};

/// Number of samples of which one is right with the probability, if a share is right.
double samples_needed(double share, double probability) {
  const double right = share * share * share;
  if (right >= 1) return 1;
  return std::ceil(std::log1p(-probability) / std::log1p(-right));
}

}  // namespace

std::optional<std::string> RigidConsensusOptions::invalid() const {
  if (!(inlier_distance > 0)) return "inlier_distance must be positive";
  if (!(min_side > 0)) return "min_side must be positive";
  if (min_inliers < 3) return "min_inliers must be at least 3";
  if (!(probability > 0 && probability < 1)) return "probability must be between 0 and 1";
  if (!(min_share >= 0.01 && min_share <= 1)) return "min_share must be between 0.01 and 1";
  if (hypotheses < 1 || hypotheses > 100) return "hypotheses must be between 1 and 100";
  if (!(distinct_rotation > 0)) return "distinct_rotation must be positive";
  if (!(distinct_translation > 0)) return "distinct_translation must be positive";
  return std::nullopt;
}

Eigen::Isometry3d fit_rigid(const Correspondences& correspondences,
                            std::span<const uint32_t> members) {
  Eigen::Vector3d target_mean = Eigen::Vector3d::Zero(), source_mean = Eigen::Vector3d::Zero();
  for (const uint32_t i : members) {
    target_mean += correspondences.target[i];
    source_mean += correspondences.source[i];
  }
  const auto n = static_cast<double>(members.size());
  target_mean /= n;
  source_mean /= n;
  Eigen::Matrix3d S = Eigen::Matrix3d::Zero();
  for (const uint32_t i : members) {
    S += (correspondences.source[i] - source_mean) *
         (correspondences.target[i] - target_mean).transpose();
  }
  Eigen::Matrix4d N;
  const Eigen::Vector3d skewed(S(1, 2) - S(2, 1), S(2, 0) - S(0, 2), S(0, 1) - S(1, 0));
  N(0, 0) = S.trace();
  N.block<1, 3>(0, 1) = skewed.transpose();
  N.block<3, 1>(1, 0) = skewed;
  N.block<3, 3>(1, 1) = S + S.transpose() - S.trace() * Eigen::Matrix3d::Identity();
  const Eigen::Vector4d q = geometry::symmetric_eigen<4>(N).vectors.col(3);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Quaterniond(q(0), q(1), q(2), q(3)).normalized().toRotationMatrix();
  T.translation() = target_mean - T.linear() * source_mean;
  return T;
}

RigidConsensus find_rigid_consensus(const Correspondences& correspondences,
                                    const RigidConsensusOptions& options) {
  RigidConsensus out;
  const size_t count = correspondences.size();
  if (count == 0) return out;
  if (count < std::max<size_t>(3, options.min_inliers)) {
    out.reason = "there are too few correspondences";
    return out;
  }
  Search search(correspondences, options);
  double needed = samples_needed(options.min_share, options.probability);
  size_t best = 0;
  while (static_cast<double>(out.samples) < needed) {
    search.draw();
    ++out.samples;
    if (search.best_count() <= best) continue;
    best = search.best_count();
    // Other poses are sought down to a quarter of the best one's inliers.
    const double share = static_cast<double>(best) / static_cast<double>(count) *
                         (options.hypotheses > 1 ? 0.25 : 1.0);
    needed = std::min(needed, samples_needed(share, options.probability));
  }
  out.hypotheses = search.finish();
  if (out.hypotheses.empty()) {
    out.reason = "no pose agrees with enough of the correspondences";
    return out;
  }
  const double share =
      static_cast<double>(out.hypotheses.front().inliers.size()) / static_cast<double>(count);
  out.probability =
      -std::expm1(static_cast<double>(out.samples) * std::log1p(-share * share * share));
  out.reason = "";
  return out;
}

}  // namespace infuse::registration
