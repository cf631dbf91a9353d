#include "fusion/dependence/shrunk_information.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::dependence {

double fast_shrinkage(double correspondences, double sigma, FastShrinkage direction) {
  if (!(correspondences >= 0) || !std::isfinite(correspondences)) return 1;
  if (!(sigma > 0) || !std::isfinite(sigma)) return 1;
  const double printed = 2 / (1 + std::exp(-correspondences / sigma)) - 1;
  return direction == FastShrinkage::kAsPrinted ? printed : 1 - printed;
}

ShrunkInformation::ShrunkInformation(std::vector<double> target)
    : target_(std::move(target)),
      joint_(target_.size() * target_.size()),
      x_(target_.size()),
      y_(target_.size()) {
  for (const double t : target_) {
    log_target_.push_back(std::log(t));
    target_squares_ += t * t;
  }
  seen_.reserve(std::min<size_t>(joint_.size(), 4096));
}

void ShrunkInformation::clear() {
  for (const auto& [x, y] : seen_) joint_[cell(x, y)] = x_[x] = y_[y] = 0;
  seen_.clear();
  total_ = 0;
}

void ShrunkInformation::add(uint32_t x, uint32_t y, double weight) {
  double& pair = joint_[cell(x, y)];
  if (pair == 0) seen_.emplace_back(x, y);
  pair += weight;
  x_[x] += weight;
  y_[y] += weight;
  total_ += weight;
}

double ShrunkInformation::optimal_shrinkage() const {
  if (!(total_ > 1)) return 1;
  double variance = 1, distance = target_squares_ * target_squares_;  // Σ (T_x T_y)² = (Σ T²)²
  for (const auto& [x, y] : seen_) {
    const double p = joint_[cell(x, y)] / total_;
    variance -= p * p;
    distance += p * (p - 2 * target_[x] * target_[y]);
  }
  if (!(distance > 0)) return 1;
  return std::clamp(variance / ((total_ - 1) * distance), 0.0, 1.0);
}

double ShrunkInformation::value(double lambda) const {
  if (!(total_ > 0)) return 0;
  const double scale = (1 - lambda) / total_;
  // Pairs that were not seen have λ T_x T_y. The sum over all pairs as if none was seen separates
  // into sums over labels; the pairs that were seen are corrected.
  double information = lambda > 0 ? lambda * std::log(lambda) : 0;
  for (size_t k = 0; k < target_.size(); ++k) {
    for (const double counted : {x_[k], y_[k]}) {
      const double marginal = lambda * target_[k] + scale * counted;
      if (lambda > 0) information += lambda * target_[k] * (log_target_[k] - std::log(marginal));
    }
  }
  for (const auto& [x, y] : seen_) {
    const double independent =
        (lambda * target_[x] + scale * x_[x]) * (lambda * target_[y] + scale * y_[y]);
    const double unseen = lambda * target_[x] * target_[y];
    const double p = unseen + scale * joint_[cell(x, y)];
    information += p * std::log(p / independent);
    if (unseen > 0) information -= unseen * std::log(unseen / independent);
  }
  return information;
}

}  // namespace infuse::dependence
