#include "fusion/registration/visual/k_means.hpp"

#include <algorithm>
#include <numeric>
#include <random>

#include "fusion/geometry/draw_uniform.hpp"

namespace infuse::registration {
namespace {

/// k-means++: each seed is a feature, drawn with the squared distance to the nearest seed so far.
Eigen::MatrixXf draw_seeds(const Eigen::MatrixXf& features, Eigen::Index words, uint64_t seed) {
  std::mt19937_64 random(seed);
  const Eigen::Index n = features.cols();
  Eigen::MatrixXf seeds(features.rows(), words);
  std::vector<double> distance(static_cast<size_t>(n), 1.0);
  for (Eigen::Index k = 0; k < words; ++k) {
    std::vector<double> sum(distance.size());
    std::partial_sum(distance.begin(), distance.end(), sum.begin());
    const double drawn = (1 + geometry::draw_uniform(random)) / 2 * sum.back();
    const auto chosen = std::min<Eigen::Index>(
        n - 1, std::upper_bound(sum.begin(), sum.end(), drawn) - sum.begin());
    seeds.col(k) = features.col(chosen);
    for (Eigen::Index i = 0; i < n; ++i) {
      const double d = (features.col(i) - seeds.col(k)).squaredNorm();
      double& least = distance[static_cast<size_t>(i)];
      least = k == 0 ? d : std::min(least, d);
    }
  }
  return seeds;
}

}  // namespace

Codebook learn_codebook(const Eigen::MatrixXf& features, size_t words, uint64_t seed,
                        int iterations) {
  Codebook codebook;
  const auto k = std::min<Eigen::Index>(static_cast<Eigen::Index>(words), features.cols());
  codebook.words = draw_seeds(features, k, seed);
  codebook.frequencies.assign(static_cast<size_t>(k), 1.0);
  std::vector<double> counts;
  for (int i = 0; i <= iterations; ++i) {
    const std::vector<uint32_t> nearest = quantise(codebook, features);
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(features.rows(), k);
    counts.assign(static_cast<size_t>(k), 0.0);
    for (size_t f = 0; f < nearest.size(); ++f) {
      sum.col(nearest[f]) += features.col(static_cast<Eigen::Index>(f)).cast<double>();
      counts[nearest[f]] += 1;
    }
    if (i == iterations) break;
    for (Eigen::Index w = 0; w < k; ++w) {
      const double count = counts[static_cast<size_t>(w)];
      if (count > 0) codebook.words.col(w) = (sum.col(w) / count).cast<float>();
    }
  }
  // Half a feature more for each word, so that none has the frequency 0.
  const double total = static_cast<double>(features.cols()) + 0.5 * static_cast<double>(k);
  for (size_t w = 0; w < counts.size(); ++w) codebook.frequencies[w] = (counts[w] + 0.5) / total;
  return codebook;
}

}  // namespace infuse::registration
