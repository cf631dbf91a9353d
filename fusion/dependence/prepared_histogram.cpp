#include "fusion/dependence/prepared_histogram.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::dependence {
namespace {

constexpr float kMaxWeight = 1e30F;  // sums of 8192 do not overflow single precision

const char* check_fixed_side(std::span<const float> fixed, std::span<const float> weights) {
  if (fixed.empty()) return "no samples";
  if (fixed.size() > 1u << 30) return "too many samples";
  if (!weights.empty() && weights.size() != fixed.size()) {
    return "the number of weights differs from the number of samples";
  }
  for (const float x : fixed) {
    if (!std::isfinite(x)) return "a sample is not finite";
  }
  for (const float w : weights) {
    if (!(w >= 0 && w <= kMaxWeight)) return "a weight is negative, above 1e30 or not a number";
  }
  return "";
}

/// Bin of a value; the bins are equal parts of the axis.
int32_t bin_index(double value, const Axis& axis) {
  const double t = (value - axis.low) / (axis.high - axis.low) * axis.bins;
  return static_cast<int32_t>(std::clamp(t, 0.0, axis.bins - 1.0));
}

}  // namespace

PreparedHistogram::PreparedHistogram(std::span<const float> fixed,
                                     const JointHistogramOptions& options,
                                     std::span<const float> weights)
    : options_(options), sample_count_(fixed.size()) {
  reason_ = options.invalid() ? "invalid options: see JointHistogramOptions::invalid()"
                              : check_fixed_side(fixed, weights);
  if (*reason_) return;
  histogram_.bins_x = options.x.bins;
  histogram_.bins_y = options.y.bins;
  if (options.window == Window::kBSpline) {
    tile_ = SplineTile(fixed, weights, options);
    return;
  }
  weights_.assign(weights.begin(), weights.end());
  row_begin_.reserve(fixed.size());
  for (const float x : fixed) row_begin_.push_back(bin_index(x, options.x) * options.y.bins);
}

const JointHistogram& PreparedHistogram::histogram(std::span<const float> moving) {
  histogram_.total = histogram_.samples = 0;
  histogram_.reason = reason_;
  if (histogram_.usable() && moving.size() != sample_count_) {
    histogram_.reason = "the sides differ in size";
  }
  if (!histogram_.usable()) return histogram_;
  const auto cells =
      static_cast<size_t>(histogram_.bins_x) * static_cast<size_t>(histogram_.bins_y);
  histogram_.mass.assign(cells, 0.0);
  if (options_.window == Window::kBSpline) {
    tile_.accumulate(moving, histogram_);
  } else {
    count_samples(moving);
  }
  if (options_.window == Window::kGaussian) smooth_gaussian(histogram_, scratch_);
  return histogram_;
}

void PreparedHistogram::count_samples(std::span<const float> moving) {
  for (size_t i = 0; i < moving.size(); ++i) {
    if (!(moving[i] > -kAbsent)) {
      histogram_.reason = "a sample is not a number";
      return;
    }
    if (moving[i] == kAbsent) continue;
    const int32_t cell = row_begin_[i] + bin_index(moving[i], options_.y);
    histogram_.mass[static_cast<size_t>(cell)] +=
        weights_.empty() ? 1.0 : static_cast<double>(weights_[i]);
    histogram_.samples += 1;
  }
  update_total(histogram_);
}

Estimate PreparedHistogram::value(Measure which, std::span<const float> moving) {
  return measure(which, histogram(moving));
}

Estimate PreparedHistogram::value_and_gradient(Measure which, std::span<const float> moving,
                                               std::span<float> gradient_out) {
  std::fill(gradient_out.begin(), gradient_out.end(), 0.0F);
  if (options_.window != Window::kBSpline) {
    return {0, "no gradient: only the B-spline window is differentiable"};
  }
  if (gradient_out.size() != sample_count_)
    return {0, "the gradient and the samples differ in size"};
  differentiate(which, histogram(moving), sensitivity_);
  if (sensitivity_.total > 0) {
    tile_.differentiate(sensitivity_.table, 1 / sensitivity_.total, moving, gradient_out);
  }
  return sensitivity_.estimate;
}

}  // namespace infuse::dependence
