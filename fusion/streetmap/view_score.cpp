#include "fusion/streetmap/view_score.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::streetmap {
namespace {

constexpr size_t kBags = 4;

}  // namespace

ViewScore::ViewScore(ViewMeasure measure, const dependence::FitOptions& fit) : measure_(measure) {
  const size_t bags = measure == ViewMeasure::kBlsmi ? kBags : 1;
  for (size_t b = 0; b < bags; ++b) bags_.emplace_back(fit);
}

void ViewScore::reserve(int samples, int labels) {
  for (dependence::LabelDependence& bag : bags_) bag.reserve(samples, kFeatures, labels);
}

const char* ViewScore::prepare(const GridSamples& samples) {
  if (measure_ == ViewMeasure::kBoundaries) return prepare_boundaries(samples.features);
  if (bags_.size() == 1) {
    bags_[0].prepare(samples.features.matrix());
    return bags_[0].reason();
  }
  // Each bag takes every kBags-th sample, from another one on: the samples are in random order.
  const Eigen::Index bags = kBags, size = samples.features.rows() / bags;
  part_.resize(size, samples.features.cols());
  for (Eigen::Index b = 0; b < bags; ++b) {
    for (Eigen::Index f = 0; f < part_.cols(); ++f) {
      for (Eigen::Index i = 0; i < size; ++i) part_(i, f) = samples.features(i * bags + b, f);
    }
    dependence::LabelDependence& bag = bags_[static_cast<size_t>(b)];
    bag.prepare(part_.matrix());
    if (*bag.reason() != '\0') return bag.reason();
  }
  return "";
}

// I(3.8): gradient times discontinuity. The table holds them without their mean; both begin at 0.
const char* ViewScore::prepare_boundaries(const FeatureTable& features) {
  if (features.cols() < kFeatures) return "boundaries need colours";
  const auto all = features.matrix();
  const auto gradient = all.col(kGradient);
  const auto discontinuity = all.col(kDiscontinuity);
  const double g = gradient.minCoeff(), d = discontinuity.minCoeff();
  likeness_.resize(static_cast<size_t>(features.rows()));
  double squares = 0;
  for (Eigen::Index i = 0; i < features.rows(); ++i) {
    const double value = (gradient[i] - g) * (discontinuity[i] - d);
    likeness_[static_cast<size_t>(i)] = value;
    squares += value * value;
  }
  likeness_norm_ = std::sqrt(squares);
  return squares > 0 ? "" : "nothing looks like a boundary";
}

// I(3.7).
double ViewScore::boundary_correlation(std::span<const int32_t> labels,
                                       const LabelWindow& window) const {
  double sum = 0, count = 0;
  for (size_t i = 0; i < labels.size(); ++i) {
    const SegmentKind kind = window.kind(labels[i]);
    const bool boundary = kind == SegmentKind::kKerb || kind == SegmentKind::kImageLine;
    sum += boundary ? likeness_[i] : 0;
    count += boundary;
  }
  return count > 0 ? sum / (likeness_norm_ * std::sqrt(count)) : 0;
}

double ViewScore::ask(std::span<const int32_t> labels, const LabelWindow& window,
                      const std::optional<dependence::HyperParameters>& kept,
                      dependence::HyperParameters* chosen) {
  if (chosen != nullptr) *chosen = {};
  if (measure_ == ViewMeasure::kBoundaries) return boundary_correlation(labels, window);
  auto keep = kept;
  double sum = 0;
  for (size_t b = 0; b < bags_.size(); ++b) {
    std::span<const int32_t> part = labels;
    if (bags_.size() > 1) {
      part_labels_.resize(labels.size() / kBags);
      for (size_t i = 0; i < part_labels_.size(); ++i) part_labels_[i] = labels[i * kBags + b];
      part = part_labels_;
    }
    const dependence::FitEstimate answer = bags_[b].ask(part, window.label_count(), keep);
    if (!answer.usable()) return 0;
    sum += answer.value;
    if (!keep) keep = answer.chosen;  // I 4.3.2: the first bag's serve all
  }
  if (chosen != nullptr) *chosen = *keep;
  return sum / static_cast<double>(bags_.size());
}

}  // namespace infuse::streetmap
