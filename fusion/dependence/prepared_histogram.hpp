#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fusion/dependence/estimate.hpp"
#include "fusion/dependence/histogram_measures.hpp"
#include "fusion/dependence/joint_histogram.hpp"
#include "fusion/dependence/spline_tile.hpp"

namespace infuse::dependence {

/// Joint histogram with a fixed x side that is binned once (lidar reflectivity), evaluated with
/// many y sides (grey values at the projections of each candidate pose). Does not allocate after
/// the first evaluation. Single-threaded.
class PreparedHistogram {
 public:
  /// @param fixed    x samples, finite
  /// @param weights  empty, or one per sample, finite and not negative
  /// Invalid input becomes the reason of every estimate.
  PreparedHistogram(std::span<const float> fixed, const JointHistogramOptions& options,
                    std::span<const float> weights = {});

  /// Number of samples of the fixed side; `moving` must have as many.
  size_t sample_count() const { return sample_count_; }

  /// Returns the joint histogram with `moving`, in the unit of y; see `kAbsent`. Valid until the
  /// next evaluation.
  const JointHistogram& histogram(std::span<const float> moving);

  /// Returns the plug-in measure.
  Estimate value(Measure which, std::span<const float> moving);

  /// Returns the measure and sets its derivative with respect to every moving sample (unit of the
  /// measure per unit of y): 0 for samples that are absent or outside the axis, and for all samples
  /// if there is no histogram. Only for `Window::kBSpline`.
  /// @param gradient  one per sample
  Estimate value_and_gradient(Measure which, std::span<const float> moving,
                              std::span<float> gradient);

 private:
  /// Fills the histogram without a window.
  void count_samples(std::span<const float> moving);

  JointHistogramOptions options_;
  size_t sample_count_ = 0;
  const char* reason_ = "";
  SplineTile tile_;                 // for the B-spline window
  std::vector<int32_t> row_begin_;  // for the others: first cell of the sample's row of the table
  std::vector<float> weights_;      // for the others: empty or one per sample
  JointHistogram histogram_;
  Sensitivity sensitivity_;
  std::vector<double> scratch_;
};

}  // namespace infuse::dependence
