#include "tests/study/places/bag_of_words.hpp"

#include <cmath>

namespace infuse::study {

BagOfWords::BagOfWords(const std::vector<std::vector<uint16_t>>& places, size_t vocabulary)
    : rarity_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(vocabulary))),
      places_(static_cast<Eigen::Index>(vocabulary), static_cast<Eigen::Index>(places.size())) {
  for (const auto& words : places) {
    std::vector<bool> seen(vocabulary, false);
    for (const uint16_t word : words) {
      if (!seen[word]) rarity_[word] += 1;
      seen[word] = true;
    }
  }
  const auto count = static_cast<double>(places.size());
  for (double& value : rarity_) value = std::log((1 + count) / (1 + value));
  for (size_t k = 0; k < places.size(); ++k)
    places_.col(static_cast<Eigen::Index>(k)) = weigh(places[k]);
}

Eigen::VectorXd BagOfWords::weigh(const std::vector<uint16_t>& words) const {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(rarity_.size());
  for (const uint16_t word : words) out[word] += rarity_[word];
  const double norm = out.norm();
  if (norm > 0) out /= norm;
  return out;
}

Eigen::VectorXd BagOfWords::similarities(const std::vector<uint16_t>& query) const {
  return places_.transpose() * weigh(query);
}

}  // namespace infuse::study
