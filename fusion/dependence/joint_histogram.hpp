#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace infuse::dependence {

/// One side of a joint histogram. Values outside [low, high] count as the nearer end.
struct Axis {
  int bins = 32;    ///< 1 … 1024; at least 4 for the cubic B-spline
  double low = 0;   ///< value at the lower end, in the samples' unit
  double high = 1;  ///< value at the upper end
};

/// How a sample spreads over the bins.
enum class Window {
  kNone,      ///< all of it in one bin
  kGaussian,  ///< the table smoothed with Silverman's bandwidth 1.06 n^(−1/5) σ, P(3.15), P(3.16)
  kBSpline,   ///< cubic B-spline over 4 × 4 bins: differentiable in the samples
};

/// What a joint histogram assumes.
struct JointHistogramOptions {
  Axis x, y;
  Window window = Window::kBSpline;

  /// What is wrong with the numbers, or nothing.
  std::optional<std::string> invalid() const;
};

/// A moving sample that takes no part: a lidar point that this hypothesis projects outside the
/// image.
inline constexpr float kAbsent = std::numeric_limits<float>::infinity();

/// Reasons that others compare with.
inline constexpr const char* kConstantSide = "one side is constant";
inline constexpr const char* kFewerSamplesThanBins = "fewer samples than bins";

/// The joint histogram of two variables.
struct JointHistogram {
  int bins_x = 0, bins_y = 0;
  std::vector<double> mass;  ///< bins_x rows of bins_y, not normalised
  double total = 0;          ///< sum of `mass`
  double samples = 0;        ///< how many samples took part
  const char* reason = "";   ///< static text: why it cannot be used; empty when it can

  bool usable() const { return *reason == '\0'; }
  double at(int x, int y) const {
    const int cell = x * bins_y + y;
    return mass[static_cast<size_t>(cell)];
  }

  /// Adds a histogram of the same shape and options: tiles of several threads or scans. False, with
  /// the reason set and nothing added, where the tile has no mass or another shape. Not for
  /// `Window::kGaussian`, whose bandwidth belongs to all samples together: add unsmoothed tables
  /// and smooth the sum.
  [[nodiscard]] bool add(const JointHistogram& tile);
};

/// The joint histogram of paired samples; `weights` empty or one a sample, finite and not negative.
/// A `kAbsent` in `y` takes no part. Reasons: sizes differ, no samples, a sample or a weight that
/// cannot be used, a side that is constant, fewer samples than bins on a side.
JointHistogram joint_histogram(std::span<const float> x, std::span<const float> y,
                               const JointHistogramOptions& options = {},
                               std::span<const float> weights = {});

/// The same for labels 0 … labels − 1 (codewords).
JointHistogram joint_counts(std::span<const int32_t> x, std::span<const int32_t> y, int labels_x,
                            int labels_y);

/// A table that is already counted, `bins_x` rows of `bins_y`.
JointHistogram joint_table(std::span<const double> mass, int bins_x, int bins_y);

/// Replaces the table by its Gaussian kernel density estimate, P(3.15), with the bandwidth P(3.16)
/// from the table's marginals. Mass that would leave the table stays in it. `scratch` is the
/// caller's, so that repeated use allocates nothing.
void smooth_gaussian(JointHistogram& histogram, std::vector<double>& scratch);

/// Sets `total` from `mass`, and the reason of a side with one occupied bin or of fewer samples
/// than bins.
void update_total(JointHistogram& histogram);

}  // namespace infuse::dependence
