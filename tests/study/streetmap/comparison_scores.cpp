#include "tests/study/streetmap/comparison_scores.hpp"

#include <cmath>

namespace infuse::streetmap {

using Eigen::Index;

void BaggedLsmiScore::reserve(int samples, int labels) {
  for (LsmiScore& bag : bags_) bag.reserve(samples, labels);
}

// Bag b holds every k-th sample from sample b on: the samples are in random order.
const char* BaggedLsmiScore::prepare(const GridSamples& samples) {
  const auto bags = static_cast<Index>(kBagCount);
  const Index size = samples.features.rows() / bags;
  bag_samples_.features.resize(size, samples.features.cols());
  for (Index b = 0; b < bags; ++b) {
    for (Index f = 0; f < samples.features.cols(); ++f) {
      for (Index i = 0; i < size; ++i)
        bag_samples_.features(i, f) = samples.features(i * bags + b, f);
    }
    const char* reason = bags_[static_cast<size_t>(b)].prepare(bag_samples_);
    if (*reason != '\0') return reason;
  }
  return "";
}

double BaggedLsmiScore::evaluate(std::span<const int32_t> labels, const LabelWindow& window,
                                 const std::optional<dependence::HyperParameters>& fixed,
                                 dependence::HyperParameters* chosen) {
  if (chosen != nullptr) *chosen = {};
  auto hyper_parameters = fixed;
  bag_labels_.resize(labels.size() / kBagCount);
  double sum = 0;
  for (size_t b = 0; b < kBagCount; ++b) {
    for (size_t i = 0; i < bag_labels_.size(); ++i) bag_labels_[i] = labels[i * kBagCount + b];
    dependence::HyperParameters used;
    sum += bags_[b].evaluate(bag_labels_, window, hyper_parameters, &used);
    if (!(used.sigma > 0)) return 0;
    hyper_parameters = used;  // I 4.3.2: all bags use those of the first
  }
  if (chosen != nullptr) *chosen = *hyper_parameters;
  return sum / static_cast<double>(kBagCount);
}

void BoundaryScore::reserve(int samples, int) { strength_.reserve(static_cast<size_t>(samples)); }

// I(3.8): gradient times discontinuity. The table holds them without their means; both are shifted
// to a minimum of 0.
const char* BoundaryScore::prepare(const GridSamples& samples) {
  const FeatureTable& features = samples.features;
  if (features.cols() < kFeatureCount) return "the boundary measure needs colours";
  const auto all = features.matrix();
  const auto gradient = all.col(kGradient);
  const auto discontinuity = all.col(kDiscontinuity);
  const double g = gradient.minCoeff(), d = discontinuity.minCoeff();
  strength_.resize(static_cast<size_t>(features.rows()));
  double squares = 0;
  for (Index i = 0; i < features.rows(); ++i) {
    const double value = (gradient[i] - g) * (discontinuity[i] - d);
    strength_[static_cast<size_t>(i)] = value;
    squares += value * value;
  }
  strength_norm_ = std::sqrt(squares);
  return squares > 0 ? "" : "no sample resembles a boundary";
}

// I(3.7).
double BoundaryScore::evaluate(std::span<const int32_t> labels, const LabelWindow& window,
                               const std::optional<dependence::HyperParameters>&,
                               dependence::HyperParameters* chosen) {
  if (chosen != nullptr) *chosen = {};
  double sum = 0, count = 0;
  for (size_t i = 0; i < labels.size(); ++i) {
    const SegmentKind kind = window.kind(labels[i]);
    const bool boundary = kind == SegmentKind::kKerb || kind == SegmentKind::kImageLine;
    sum += boundary ? strength_[i] : 0;
    count += boundary;
  }
  return count > 0 ? sum / (strength_norm_ * std::sqrt(count)) : 0;
}

}  // namespace infuse::streetmap
