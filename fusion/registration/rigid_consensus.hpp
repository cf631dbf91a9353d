#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace infuse::registration {

/// Points that may be the same: entry i of one array corresponds to entry i of the other, m.
struct Correspondences {
  std::vector<Eigen::Vector3d> target, source;

  size_t size() const { return source.size(); }
};

/// Computes the rigid motion that takes the source points at `members` to their target points, by
/// least squares: B. K. P. Horn, Closed-form solution of absolute orientation using unit
/// quaternions, 1987; the same optimum as Arun et al., P 4.2.1. At least three points, not on a
/// line, determine it.
Eigen::Isometry3d fit_rigid(const Correspondences& correspondences,
                            std::span<const uint32_t> members);

/// Settings of the consensus.
struct RigidConsensusOptions {
  double inlier_distance = 0.6;  ///< m, up to which a moved source point agrees with its target
  double min_side = 2;           ///< m, shortest side of a sampled triangle, and of its counterpart
  size_t min_inliers = 8;        ///< fewer are no consensus
  double probability = 0.999;    ///< that a sample of three right correspondences was drawn: a
                                 ///< failure is one in a thousand (Fischler and Bolles 1981)
  double min_share = 0.02;  ///< smallest share of right correspondences that this holds for; bounds
                            ///< time: 860 000 samples
  size_t hypotheses = 1;    ///< maximum number of poses that are returned
  double distinct_rotation = 0.2;   ///< rad, and
  double distinct_translation = 2;  ///< m: poses closer than both are one hypothesis
  uint64_t seed = 1;                ///< of the samples

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// A pose and the correspondences that agree with it.
struct RigidHypothesis {
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
  std::vector<uint32_t> inliers;
};

/// Poses on which many correspondences agree, or the reason why there is none.
struct RigidConsensus {
  std::vector<RigidHypothesis> hypotheses;  ///< most inliers first
  uint64_t samples = 0;                     ///< drawn triples
  /// Probability that a triple of right correspondences was among the samples, if the inliers of
  /// the first hypothesis are the right ones.
  double probability = 0;
  const char* reason = "no correspondences were given";  ///< static text; empty if usable

  bool usable() const { return *reason == '\0'; }
};

/// Finds rigid motions by random samples of three correspondences (RANSAC), P algorithm 2. A sample
/// whose triangles differ in a side is left out at once; inliers are fitted by least squares.
/// It ends as soon as `probability` holds for the share of inliers found; with several hypotheses
/// for a quarter of it, so that rarer poses are found too.
RigidConsensus find_rigid_consensus(const Correspondences& correspondences,
                                    const RigidConsensusOptions& options);

}  // namespace infuse::registration
