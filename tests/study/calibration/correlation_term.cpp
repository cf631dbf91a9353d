#include "tests/study/calibration/correlation_term.hpp"

#include <cmath>
#include <utility>
#include <vector>

namespace infuse::study {
namespace {

class CorrelationTerm : public calibration::DependenceTerm {
 public:
  explicit CorrelationTerm(std::vector<float> lidar) : lidar_(std::move(lidar)) {
    for (float& value : lidar_) {
      if (std::isnan(value)) value = 0;
    }
  }

  dependence::Estimate evaluate(std::span<const float> image, std::span<float> gradient) override {
    if (lidar_.empty()) return {.value = 0, .reason = "no points in view"};
    const auto n = static_cast<double>(lidar_.size());
    double sum = 0;
    for (size_t i = 0; i < lidar_.size(); ++i) {
      if (std::isfinite(image[i])) sum += double{lidar_[i]} * double{image[i]};
    }
    for (size_t i = 0; i < gradient.size(); ++i) gradient[i] = static_cast<float>(lidar_[i] / n);
    return {.value = sum / n};
  }

  size_t sample_count() const override { return lidar_.size(); }

 private:
  std::vector<float> lidar_;
};

}  // namespace

std::unique_ptr<calibration::DependenceTerm> make_correlation_term(
    const calibration::TermOptions& options, const calibration::VisiblePoints& points) {
  return std::make_unique<CorrelationTerm>(points.lidar[calibration::index(options.lidar.front())]);
}

}  // namespace infuse::study
