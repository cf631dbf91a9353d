#include "fusion/streetmap/view_score.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::streetmap {
namespace {

constexpr size_t kBagCount = 4;

}  // namespace

ViewScore::ViewScore(ViewMeasure measure, const dependence::FitOptions& fit) : measure_(measure) {
  const size_t bags = measure == ViewMeasure::kBlsmi ? kBagCount : 1;
  for (size_t b = 0; b < bags; ++b) bags_.emplace_back(fit);
}

void ViewScore::reserve(int samples, int labels) {
  for (dependence::LabelDependence& bag : bags_) bag.reserve(samples, kFeatureCount, labels);
}

const char* ViewScore::prepare(const GridSamples& samples) {
  if (measure_ == ViewMeasure::kBoundaries) return prepare_boundaries(samples.features);
  if (bags_.size() == 1) {
    bags_[0].prepare(samples.features.matrix());
    return bags_[0].reason();
  }
  // Bag b holds every kBags-th sample from sample b on: the samples are in random order.
  const Eigen::Index bags = kBagCount, size = samples.features.rows() / bags;
  bag_features_.resize(size, samples.features.cols());
  for (Eigen::Index b = 0; b < bags; ++b) {
    for (Eigen::Index f = 0; f < bag_features_.cols(); ++f) {
      for (Eigen::Index i = 0; i < size; ++i)
        bag_features_(i, f) = samples.features(i * bags + b, f);
    }
    dependence::LabelDependence& bag = bags_[static_cast<size_t>(b)];
    bag.prepare(bag_features_.matrix());
    if (*bag.reason() != '\0') return bag.reason();
  }
  return "";
}

// I(3.8): gradient times discontinuity. The table holds them without their means; both are shifted
// to a minimum of 0.
const char* ViewScore::prepare_boundaries(const FeatureTable& features) {
  if (features.cols() < kFeatureCount) return "the boundary measure needs colours";
  const auto all = features.matrix();
  const auto gradient = all.col(kGradient);
  const auto discontinuity = all.col(kDiscontinuity);
  const double g = gradient.minCoeff(), d = discontinuity.minCoeff();
  boundary_strength_.resize(static_cast<size_t>(features.rows()));
  double squares = 0;
  for (Eigen::Index i = 0; i < features.rows(); ++i) {
    const double value = (gradient[i] - g) * (discontinuity[i] - d);
    boundary_strength_[static_cast<size_t>(i)] = value;
    squares += value * value;
  }
  boundary_strength_norm_ = std::sqrt(squares);
  return squares > 0 ? "" : "no sample resembles a boundary";
}

// I(3.7).
double ViewScore::boundary_correlation(std::span<const int32_t> labels,
                                       const LabelWindow& window) const {
  double sum = 0, count = 0;
  for (size_t i = 0; i < labels.size(); ++i) {
    const SegmentKind kind = window.kind(labels[i]);
    const bool boundary = kind == SegmentKind::kKerb || kind == SegmentKind::kImageLine;
    sum += boundary ? boundary_strength_[i] : 0;
    count += boundary;
  }
  return count > 0 ? sum / (boundary_strength_norm_ * std::sqrt(count)) : 0;
}

double ViewScore::evaluate(std::span<const int32_t> labels, const LabelWindow& window,
                           const std::optional<dependence::HyperParameters>& fixed,
                           dependence::HyperParameters* chosen) {
  if (chosen != nullptr) *chosen = {};
  if (measure_ == ViewMeasure::kBoundaries) return boundary_correlation(labels, window);
  auto hyper_parameters = fixed;
  double sum = 0;
  for (size_t b = 0; b < bags_.size(); ++b) {
    std::span<const int32_t> part = labels;
    if (bags_.size() > 1) {
      bag_labels_.resize(labels.size() / kBagCount);
      for (size_t i = 0; i < bag_labels_.size(); ++i) bag_labels_[i] = labels[i * kBagCount + b];
      part = bag_labels_;
    }
    const dependence::FitEstimate estimate =
        bags_[b].evaluate(part, window.label_count(), hyper_parameters);
    if (!estimate.usable()) return 0;
    sum += estimate.value;
    if (!hyper_parameters)
      hyper_parameters = estimate.hyper_parameters;  // I 4.3.2: all bags use those of the first
  }
  if (chosen != nullptr) *chosen = *hyper_parameters;
  return sum / static_cast<double>(bags_.size());
}

}  // namespace infuse::streetmap
