#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fusion/dependence/joint_histogram.hpp"
#include "fusion/dependence/spline_kernels.hpp"

namespace infuse::dependence {

/// Fast cubic B-spline window of a joint histogram. The four weights of each sample of the fixed
/// side are computed once, and the sixteen products of a sample are added to one aligned block of
/// 64 bytes for its pair of knot intervals. Blocks overlap as bins: they are folded into the table
/// in double every few thousand samples, so that float sums stay short.
class SplineTile {
 public:
  SplineTile() = default;

  /// @param fixed    finite x samples
  /// @param weights  empty or one per sample
  /// @param options  valid, with at least 4 bins per side
  SplineTile(std::span<const float> fixed, std::span<const float> weights,
             const JointHistogramOptions& options);

  /// Adds all samples to `histogram`, whose `mass` has its shape and is zero, and completes it.
  void accumulate(std::span<const float> moving, JointHistogram& histogram);

  /// Computes gradient_i = scale · d/dy_i Σ table · window(x_i, y_i).
  void differentiate(std::span<const double> table, double scale, std::span<const float> moving,
                     std::span<float> gradient);

 private:
  void flush_blocks(JointHistogram& histogram);

  SplineAxis axis() const;

  /// Weights of the fixed side times the weight of the sample.
  std::vector<Float4> weights_;
  std::vector<int32_t> first_block_;  ///< of the sample's row of blocks
  std::vector<Float4> blocks_;  ///< four vectors per block; the last block is for absent samples
  int32_t intervals_x_ = 0, intervals_y_ = 0;
  bool fixed_is_constant_ = false;
  float low_ = 0, scale_ = 0;  ///< of y: interval = (y − low) · scale
};

}  // namespace infuse::dependence
