#pragma once

#include "fusion/registration/visual/codebook.hpp"

namespace infuse::registration {

/// Learns a codebook by k-means (Lloyd, from seeds drawn as k-means++): at most `words` codewords
/// with the frequencies of the features (one per column) nearest to each. The same seed and
/// features give the same codebook.
Codebook learn_codebook(const Eigen::MatrixXf& features, size_t words, uint64_t seed,
                        int iterations = 25);

}  // namespace infuse::registration
