#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fusion/dependence/estimate.hpp"
#include "fusion/dependence/histogram_measures.hpp"
#include "fusion/dependence/joint_histogram.hpp"
#include "fusion/dependence/spline_tile.hpp"

namespace infuse::dependence {

/// A joint histogram whose x side is fixed and binned once (lidar reflectivity), then asked with
/// one y side a hypothesis (grey values at the projections). After the first question it allocates
/// nothing. Not for two threads at a time: give each thread its own, over its own part of the
/// samples, and add the histograms.
class PreparedHistogram {
 public:
  /// @param fixed    x samples, finite
  /// @param weights  empty, or one a sample, finite and not negative
  /// What is wrong with them becomes the reason of every answer.
  PreparedHistogram(std::span<const float> fixed, const JointHistogramOptions& options,
                    std::span<const float> weights = {});

  /// How many samples the fixed side has; `moving` must have as many.
  size_t sample_count() const { return sample_count_; }

  /// The joint histogram with `moving`, in y's unit; see `kAbsent`. Valid until the next question.
  const JointHistogram& histogram(std::span<const float> moving);

  /// The plug-in measure.
  Estimate value(Measure which, std::span<const float> moving);

  /// The measure, and its derivative with respect to every moving sample (measure's unit per unit
  /// of y): 0 for samples that are absent or outside the axis. Only for `Window::kBSpline`. Where
  /// there is no histogram the gradient is 0.
  /// @param gradient  as many as samples
  Estimate value_and_gradient(Measure which, std::span<const float> moving,
                              std::span<float> gradient);

  /// The gradient alone, of a measure of a larger histogram that this one is a tile of.
  /// @param sensitivity  of the sum of the tiles
  void gradient(const Sensitivity& sensitivity, std::span<const float> moving,
                std::span<float> gradient);

 private:
  /// Fills the histogram without a window.
  void count_samples(std::span<const float> moving);

  JointHistogramOptions options_;
  size_t sample_count_ = 0;
  const char* reason_ = "";
  SplineTile tile_;                 // for the B-spline window
  std::vector<int32_t> row_begin_;  // for the others: where the sample's row of the table begins
  std::vector<float> weights_;      // for the others: empty or one a sample
  JointHistogram histogram_;
  Sensitivity sensitivity_;
  std::vector<double> scratch_;
};

}  // namespace infuse::dependence
