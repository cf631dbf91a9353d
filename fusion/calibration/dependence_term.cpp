#include "fusion/calibration/dependence_term.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "fusion/calibration/lidar_features.hpp"
#include "fusion/dependence/prepared_histogram.hpp"

namespace infuse::calibration {
namespace {

using dependence::Estimate;
using dependence::Measure;

/// A measure of the joint histogram of both sides.
class HistogramTerm : public DependenceTerm {
 public:
  /// `chosen`: which points take part; `lidar`: their values.
  HistogramTerm(Measure measure, dependence::Window window, int bins, std::vector<uint32_t> chosen,
                std::span<const float> lidar)
      : measure_(measure),
        window_(window),
        chosen_(std::move(chosen)),
        histogram_(lidar, {.x = {.bins = bins}, .y = {.bins = bins}, .window = window}) {}

  Estimate evaluate(std::span<const float> image, std::span<float> gradient) override {
    if (chosen_.size() == image.size()) return ask(image, gradient);
    image_.resize(chosen_.size());
    for (size_t k = 0; k < chosen_.size(); ++k) image_[k] = image[chosen_[k]];
    if (gradient.empty()) return ask(image_, {});
    gradient_.resize(chosen_.size());
    const Estimate estimate = ask(image_, gradient_);
    std::fill(gradient.begin(), gradient.end(), 0.0F);
    for (size_t k = 0; k < chosen_.size(); ++k) gradient[chosen_[k]] = gradient_[k];
    return estimate;
  }

  size_t samples() const override { return chosen_.size(); }

 private:
  Estimate ask(std::span<const float> image, std::span<float> gradient) {
    if (gradient.empty()) return histogram_.value(measure_, image);
    if (window_ == dependence::Window::kBSpline) {
      return histogram_.value_and_gradient(measure_, image, gradient);
    }
    std::fill(gradient.begin(), gradient.end(), 0.0F);
    return histogram_.value(measure_, image);
  }

  Measure measure_;
  dependence::Window window_;
  std::vector<uint32_t> chosen_;
  std::vector<float> image_, gradient_;  // of the chosen, where not all are
  dependence::PreparedHistogram histogram_;
};

/// I(4.4): mean of lidar value times image value.
class CorrelationTerm : public DependenceTerm {
 public:
  explicit CorrelationTerm(std::vector<float> lidar) : lidar_(std::move(lidar)) {
    for (float& value : lidar_) {
      if (std::isnan(value)) value = 0;
    }
  }

  Estimate evaluate(std::span<const float> image, std::span<float> gradient) override {
    if (lidar_.empty()) return {.value = 0, .reason = "no points in view"};
    const auto n = static_cast<double>(lidar_.size());
    double sum = 0;
    for (size_t i = 0; i < lidar_.size(); ++i) {
      if (std::isfinite(image[i])) sum += double{lidar_[i]} * double{image[i]};
    }
    for (size_t i = 0; i < gradient.size(); ++i) gradient[i] = static_cast<float>(lidar_[i] / n);
    return {.value = sum / n};
  }

  size_t samples() const override { return lidar_.size(); }

 private:
  std::vector<float> lidar_;
};

std::vector<NamedMeasure> make_named_measures() {
  using enum MeasureKind;
  const auto reflectivity = [](MeasureKind kind, int bins) {
    return TermOptions{.measure = kind, .bins = bins, .equalize = false};
  };
  TermOptions raw = reflectivity(kMutualInformation, 32);
  raw.lidar = LidarFeature::kReflectivity;
  raw.image = ImageFeature::kGrey;
  const TermOptions edges{.lidar = LidarFeature::kDiscontinuity, .image = ImageFeature::kEdge};
  TermOptions levinson = edges;
  levinson.measure = kCorrelation;
  levinson.equalize = false;
  return {
      {"joint",
       "MI of relative reflectivity and local grey + MI of depth edges and image edges",
       {TermOptions{}, edges},
       true,
       true},
      {"edges",
       "MI of depth edges and image edges, by rank: without reflectivity (P 6.2.1)",
       {edges},
       true,
       true},
      {"mi",
       "mutual information, P(3.17), B-spline window of 32 bins",
       {reflectivity(kMutualInformation, 32)},
       false,
       true},
      {"mi-raw", "the same of reflectivity and grey as the sensors state them", {raw}, false, true},
      {"mi-kde",
       "mutual information, P(3.17), Gaussian KDE on 256 bins",
       {reflectivity(kMutualInformationKde, 256)},
       false,
       false},
      {"nmi",
       "normalised mutual information, I(4.2)",
       {reflectivity(kNormalisedMutualInformation, 32)},
       false,
       true},
      {"chi2", "chi-squared, P(3.25)", {reflectivity(kChiSquared, 32)}, false, true},
      {"smi",
       "discretised squared-loss mutual information, I(4.3)",
       {reflectivity(kSquaredLossMutualInformation, 32)},
       false,
       true},
      {"levinson-thrun", "depth edges times image edges, P(3.23), I(4.4)", {levinson}, false, true},
  };
}

const std::vector<NamedMeasure>& all_measures() {
  static const std::vector<NamedMeasure> measures = make_named_measures();
  return measures;
}

}  // namespace

std::optional<std::string> TermOptions::invalid() const {
  if (!(weight > 0) || !std::isfinite(weight)) return "weight must be positive";
  if (bins < 4 || bins > 1024) return "bins must lie in 4 … 1024";
  return std::nullopt;
}

std::vector<uint32_t> taking_part(std::span<const float> lidar) {
  std::vector<uint32_t> chosen;
  for (size_t i = 0; i < lidar.size(); ++i) {
    if (!std::isnan(lidar[i])) chosen.push_back(static_cast<uint32_t>(i));
  }
  return chosen;
}

std::unique_ptr<DependenceTerm> make_term(const TermOptions& options, const VisiblePoints& points) {
  std::vector<float> lidar = points.lidar[index(options.lidar)];
  if (options.measure == MeasureKind::kCorrelation) {
    return std::make_unique<CorrelationTerm>(std::move(lidar));
  }
  std::vector<uint32_t> chosen = taking_part(lidar);
  for (size_t k = 0; k < chosen.size(); ++k) lidar[k] = lidar[chosen[k]];
  lidar.resize(chosen.size());
  if (options.equalize) equalize(lidar);
  const auto histogram = [&](Measure measure, dependence::Window window) {
    return std::make_unique<HistogramTerm>(measure, window, options.bins, std::move(chosen), lidar);
  };
  using dependence::Window;
  switch (options.measure) {
    case MeasureKind::kMutualInformation:
      return histogram(Measure::kMutualInformation, Window::kBSpline);
    case MeasureKind::kMutualInformationKde:
      return histogram(Measure::kMutualInformation, Window::kGaussian);
    case MeasureKind::kNormalisedMutualInformation:
      return histogram(Measure::kNormalisedMutualInformation, Window::kBSpline);
    case MeasureKind::kChiSquared:
      return histogram(Measure::kChiSquared, Window::kBSpline);
    case MeasureKind::kSquaredLossMutualInformation:
    case MeasureKind::kCorrelation:  // dealt with above
      break;
  }
  return histogram(Measure::kSquaredLossMutualInformation, Window::kBSpline);
}

std::span<const NamedMeasure> named_measures() { return all_measures(); }

const NamedMeasure* find_measure(const std::string& name) {
  const auto& measures = all_measures();
  const auto at =
      std::find_if(measures.begin(), measures.end(), [&](const auto& m) { return m.name == name; });
  return at == measures.end() ? nullptr : &*at;
}

}  // namespace infuse::calibration
