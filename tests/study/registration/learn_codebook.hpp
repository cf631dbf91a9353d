#pragma once

#include <ostream>

#include "fusion/registration/visual/codebook.hpp"
#include "fusion/registration/visual/scan_features.hpp"
#include "tests/study/registration/rendered_drive.hpp"

namespace infuse::study {

/// How a codebook is learned.
struct CodebookRecipe {
  uint64_t first_seed = 1;  ///< of the drives: seeds 1 … 999 are for learning, others for testing
  int drives = 6;
  size_t words = 100;
};

/// Features of one kind of a scan. Throws std::runtime_error with what is wrong.
registration::ScanFeatures features_of(const PosedScan& scan, const Rig& rig,
                                       registration::ScanFeature feature);

/// Features of the drives of a recipe, one per column, for each of `kinds`.
std::vector<Eigen::MatrixXf> training_features(const CodebookRecipe& recipe,
                                               const std::vector<registration::ScanFeature>& kinds);

/// Writes a codebook of FPFH and SIFT in the form of
/// fusion/registration/visual/learned_codebook.inc.
void write_codebook(std::ostream& out, const registration::Codebook& codebook,
                    const CodebookRecipe& recipe);

}  // namespace infuse::study
