#include "fusion/registration/visual/codebook.hpp"

#include <cmath>
#include <numeric>

namespace infuse::registration {

std::optional<std::string> Codebook::invalid() const {
  if (words.cols() == 0) return "the codebook is empty";
  if (static_cast<size_t>(words.cols()) != frequencies.size()) {
    return "the codebook has not one frequency per codeword";
  }
  if (!words.allFinite()) return "a codeword is not finite";
  for (const double f : frequencies) {
    if (!(f > 0 && f <= 1)) return "the frequency of a codeword is not between 0 and 1";
  }
  const double sum = std::accumulate(frequencies.begin(), frequencies.end(), 0.0);
  if (std::abs(sum - 1) > 1e-6) return "the frequencies of the codewords do not sum to 1";
  return std::nullopt;
}

std::vector<uint32_t> quantise(const Codebook& codebook, const Eigen::MatrixXf& features) {
  // ‖f − w‖² = ‖f‖² − 2 (wᵀf − ‖w‖²/2), in sums of a fixed order: the same word everywhere.
  const Eigen::Index dimension = codebook.words.rows();
  std::vector<float> half_norm(codebook.size(), 0.0F);
  const Eigen::MatrixXf by_dimension = codebook.words.transpose();  // a column per dimension
  for (Eigen::Index d = 0; d < dimension; ++d) {
    for (size_t k = 0; k < codebook.size(); ++k) {
      const float w = by_dimension(static_cast<Eigen::Index>(k), d);
      half_norm[k] += w * w / 2;
    }
  }
  std::vector<uint32_t> words;
  words.reserve(static_cast<size_t>(features.cols()));
  std::vector<float> score(codebook.size());
  for (Eigen::Index i = 0; i < features.cols(); ++i) {
    for (size_t k = 0; k < score.size(); ++k) score[k] = -half_norm[k];
    for (Eigen::Index d = 0; d < dimension; ++d) {
      const float f = features(d, i);
      const float* w = by_dimension.col(d).data();
      for (size_t k = 0; k < score.size(); ++k) score[k] += f * w[k];
    }
    words.push_back(
        static_cast<uint32_t>(std::max_element(score.begin(), score.end()) - score.begin()));
  }
  return words;
}

}  // namespace infuse::registration
