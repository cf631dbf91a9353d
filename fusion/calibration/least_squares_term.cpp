#include "fusion/calibration/least_squares_term.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "fusion/dependence/bagged_lsmi.hpp"

namespace infuse::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr int kBagSize = 2000;           // samples; I 4.3.2: a hundredth of 20 scans' points
constexpr int kMaxLsmiSamples = 20'000;  // of LSMI

/// Factor that makes a feature's variance one.
struct Scale {
  double mean = 0;
  double factor = 1;
};

Scale unit_variance_scale(const MatrixXd& samples, Index column) {
  const double mean = samples.col(column).mean();
  const double variance = (samples.col(column).array() - mean).square().mean();
  return {.mean = mean, .factor = variance > 0 ? 1 / std::sqrt(variance) : 1};
}

dependence::BagOptions bag_options(const TermOptions& options, size_t samples) {
  const bool bagged = options.estimator == Estimator::kBlsmi;
  const auto max_samples =
      static_cast<int>(std::min<size_t>(samples, bagged ? kBagSize : kMaxLsmiSamples));
  return {.bags = bagged ? options.bags : 1, .bag_size = std::max(max_samples, 2)};
}

class LeastSquaresTerm : public DependenceTerm {
 public:
  LeastSquaresTerm(const TermOptions& options, std::vector<uint32_t> chosen, MatrixXd lidar)
      : chosen_(std::move(chosen)),
        features_(options.image.size()),
        lsmi_(lidar, bag_options(options, chosen_.size())) {}

  dependence::Estimate evaluate(std::span<const float> image, std::span<float> gradient) override {
    const size_t points = image.size() / features_;
    samples_.resize(static_cast<Index>(chosen_.size()), static_cast<Index>(features_));
    for (size_t f = 0; f < features_; ++f) fill_column(image.subspan(f * points, points), f);
    const auto fit = lsmi_.evaluate(samples_, gradient.empty() ? nullptr : &by_sample_);
    std::fill(gradient.begin(), gradient.end(), 0.0F);
    if (by_sample_.size() > 0 && fit.usable() && !gradient.empty()) {
      for (size_t f = 0; f < features_; ++f) {
        for (size_t k = 0; k < chosen_.size(); ++k) {
          gradient[f * points + chosen_[k]] = static_cast<float>(
              scales_[f].factor * by_sample_(static_cast<Index>(k), static_cast<Index>(f)));
        }
      }
    }
    return fit;
  }

  size_t sample_count() const override { return chosen_.size(); }

 private:
  /// Returns column `f` of the samples. The scale is that of the first evaluation: one that
  /// followed the pose would contribute to the derivative. Points that the camera does not see have
  /// the mean.
  void fill_column(std::span<const float> image, size_t f) {
    const auto column = static_cast<Index>(f);
    double seen = 0, sum = 0;
    for (const uint32_t i : chosen_) {
      if (!std::isfinite(image[i])) continue;
      sum += image[i];
      ++seen;
    }
    const double average = seen > 0 ? sum / seen : 0;
    for (size_t k = 0; k < chosen_.size(); ++k) {
      const float value = image[chosen_[k]];
      samples_(static_cast<Index>(k), column) = std::isfinite(value) ? value : average;
    }
    if (scales_.size() <= f) scales_.push_back(unit_variance_scale(samples_, column));
    samples_.col(column) = (samples_.col(column).array() - scales_[f].mean) * scales_[f].factor;
  }

  std::vector<uint32_t> chosen_;
  size_t features_;
  dependence::BaggedLsmi lsmi_;
  std::vector<Scale> scales_;
  MatrixXd samples_, by_sample_;
};

}  // namespace

std::unique_ptr<DependenceTerm> make_least_squares_term(
    const TermOptions& options, std::vector<uint32_t> chosen,
    const std::vector<std::vector<float>>& columns) {
  MatrixXd lidar(static_cast<Index>(chosen.size()), static_cast<Index>(columns.size()));
  for (Index f = 0; f < lidar.cols(); ++f) {
    for (Index k = 0; k < lidar.rows(); ++k) {
      lidar(k, f) = columns[static_cast<size_t>(f)][static_cast<size_t>(k)];
    }
    const Scale scale = unit_variance_scale(lidar, f);
    lidar.col(f) = (lidar.col(f).array() - scale.mean) * scale.factor;
  }
  return std::make_unique<LeastSquaresTerm>(options, std::move(chosen), std::move(lidar));
}

}  // namespace infuse::calibration
