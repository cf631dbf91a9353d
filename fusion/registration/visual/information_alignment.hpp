#pragma once

#include <optional>
#include <string>

#include "fusion/registration/registration_result.hpp"
#include "fusion/registration/visual/codeword_information.hpp"

namespace infuse::registration {

/// How the maximum of the mutual information is found.
enum class InformationOptimizer : uint8_t {
  kSimplex,  ///< Nelder–Mead from the identity, P algorithm 4
  kSearch,   ///< a grid of planar poses, then Nelder–Mead from the best of them
};

/// Settings of an alignment by mutual information.
struct InformationAlignmentOptions {
  InformationOptimizer optimizer = InformationOptimizer::kSearch;
  ShrinkageRule shrinkage = ShrinkageRule::kByCorrespondences;
  double coarse_radius = 1.5;  ///< m, of correspondences at first
  double fine_radius = 0.3;    ///< m, of correspondences in the end
  double max_distance = 12;    ///< m, between the scans, for the grid
  /// rad, change of heading between the scans, for the grid: above π, at a crossing anything.
  double max_heading = 3.2;
  int candidates = 8;               ///< maximum number of grid poses that are refined
  size_t min_codewords = 60;        ///< of each scan; fewer are not aligned
  size_t min_correspondences = 12;  ///< of equal codewords at the result; fewer are not trusted
  /// Maximum mutual information of the next best pose, as a share of the result's; a higher one
  /// means that the result is ambiguous.
  double max_runner_up = 0.8;

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Aligns two scans by maximising the mutual information of their codewords, P 4.3 and algorithm 4.
/// The source is assumed to be upright and within the options' distance and heading. The objective
/// is constant over small motions, so its maximum is an area: the pose in it is the least-squares
/// fit of the corresponding points with equal codewords. `codebook.invalid()` and
/// `options.invalid()` must be empty and all codewords be in the codebook. Deterministic.
RegistrationResult align_by_information(const Codebook& codebook, const CodewordCloud& target,
                                        const CodewordCloud& source,
                                        const InformationAlignmentOptions& options = {});

}  // namespace infuse::registration
