#include "fusion/calibration/dependence_term.hpp"

#include <algorithm>
#include <cmath>

#include "fusion/calibration/least_squares_term.hpp"
#include "fusion/dependence/prepared_histogram.hpp"
#include "fusion/features/ranks.hpp"

namespace infuse::calibration {
namespace {

using dependence::Estimate;

/// Measure of the joint histogram of lidar and image.
class HistogramTerm : public DependenceTerm {
 public:
  /// `chosen`: indices of the points that are compared; `lidar`: their values.
  HistogramTerm(Measure measure, dependence::Window window, int bins, std::vector<uint32_t> chosen,
                std::span<const float> lidar)
      : measure_(measure),
        window_(window),
        chosen_(std::move(chosen)),
        histogram_(lidar, {.x = {.bins = bins}, .y = {.bins = bins}, .window = window}) {}

  Estimate evaluate(std::span<const float> image, std::span<float> gradient) override {
    if (chosen_.size() == image.size()) return evaluate_chosen(image, gradient);
    image_.resize(chosen_.size());
    for (size_t k = 0; k < chosen_.size(); ++k) image_[k] = image[chosen_[k]];
    if (gradient.empty()) return evaluate_chosen(image_, {});
    gradient_.resize(chosen_.size());
    const Estimate estimate = evaluate_chosen(image_, gradient_);
    std::fill(gradient.begin(), gradient.end(), 0.0F);
    for (size_t k = 0; k < chosen_.size(); ++k) gradient[chosen_[k]] = gradient_[k];
    return estimate;
  }

  size_t sample_count() const override { return chosen_.size(); }

 private:
  Estimate evaluate_chosen(std::span<const float> image, std::span<float> gradient) {
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

}  // namespace

std::optional<std::string> TermOptions::invalid() const {
  if (!(weight > 0) || !std::isfinite(weight)) return "weight must be positive";
  if (bins < 4 || bins > 1024) return "bins must be between 4 and 1024";
  if (bags < 1 || bags > 100'000) return "bags must be between 1 and 100000";
  if (lidar.empty() || image.empty())
    return "at least one lidar and one image feature must be given";
  const bool several = estimator == Estimator::kLsmi || estimator == Estimator::kBlsmi;
  if (!several && (lidar.size() > 1 || image.size() > 1)) {
    return "only lsmi and blsmi accept several features";
  }
  return std::nullopt;
}

std::vector<uint32_t> select_term_points(const TermOptions& options, const VisiblePoints& points) {
  std::vector<uint32_t> chosen;
  for (size_t i = 0; i < points.size(); ++i) {
    const bool compared =
        std::none_of(options.lidar.begin(), options.lidar.end(), [&](LidarFeature feature) {
          const bool edge_of_several = is_edge(feature) && options.lidar.size() > 1;
          return !edge_of_several && std::isnan(points.lidar[index(feature)][i]);
        });
    if (compared) chosen.push_back(static_cast<uint32_t>(i));
  }
  return chosen;
}

std::unique_ptr<DependenceTerm> make_term(const TermOptions& options, const VisiblePoints& points) {
  if (options.make) return options.make(options, points);
  std::vector<uint32_t> chosen = select_term_points(options, points);
  std::vector<std::vector<float>> lidar;
  for (const LidarFeature feature : options.lidar) {
    const std::vector<float>& all = points.lidar[index(feature)];
    std::vector<float>& column = lidar.emplace_back();
    for (const uint32_t i : chosen) column.push_back(std::isnan(all[i]) ? 0.0F : all[i]);
    if (options.equalize) features::equalize(column);
  }
  if (options.estimator == Estimator::kLsmi || options.estimator == Estimator::kBlsmi)
    return make_least_squares_term(options, std::move(chosen), lidar);
  const auto window = options.estimator == Estimator::kKernelDensity ? dependence::Window::kGaussian
                                                                     : dependence::Window::kBSpline;
  return std::make_unique<HistogramTerm>(options.measure, window, options.bins, std::move(chosen),
                                         lidar.front());
}

}  // namespace infuse::calibration
