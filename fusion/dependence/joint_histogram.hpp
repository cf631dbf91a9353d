#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace infuse::dependence {

/// Maximum number of bins of an axis: bounds memory.
inline constexpr int kMaxBins = 1024;

/// One axis of a joint histogram. Values outside [low, high] count as the nearer end.
struct Axis {
  int bins = 32;    ///< 1 … `kMaxBins`; at least 4 for the cubic B-spline
  double low = 0;   ///< lower end, in the unit of the samples
  double high = 1;  ///< upper end
};

/// Window with which a sample is spread over the bins.
enum class Window {
  kNone,      ///< none: one bin per sample
  kGaussian,  ///< table smoothed with Silverman's bandwidth 1.06 n^(−1/5) σ, P(3.15), P(3.16)
  kBSpline,   ///< cubic B-spline over 4 × 4 bins: differentiable in the samples
};

/// Settings of a joint histogram.
struct JointHistogramOptions {
  Axis x, y;                         ///< their bins
  Window window = Window::kBSpline;  ///< of the density

  /// Returns what is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Value of a moving sample that is left out: a lidar point that projects outside the image.
inline constexpr float kAbsent = std::numeric_limits<float>::infinity();

/// Reasons that callers compare with.
inline constexpr const char* kConstantSide = "one side is constant";
inline constexpr const char* kFewerSamplesThanBins = "fewer samples than bins";

/// Joint histogram of two variables.
struct JointHistogram {
  int bins_x = 0, bins_y = 0;  ///< number of bins
  std::vector<double> mass;    ///< bins_x rows of bins_y, not normalised
  double total = 0;            ///< sum of `mass`
  double samples = 0;          ///< number of samples counted
  const char* reason = "";     ///< static text: why it is unusable; empty if usable

  bool usable() const { return *reason == '\0'; }  ///< it may be used
  /// Mass of a cell.
  double at(int x, int y) const {
    const int cell = x * bins_y + y;
    return mass[static_cast<size_t>(cell)];
  }
};

/// Computes the joint histogram of paired samples; `weights` is empty or has one value per sample,
/// finite and not negative. Samples with `kAbsent` in `y` are left out. Reasons: sizes differ, no
/// samples, an invalid sample or weight, a constant side, fewer samples than bins on a side.
JointHistogram joint_histogram(std::span<const float> x, std::span<const float> y,
                               const JointHistogramOptions& options = {},
                               std::span<const float> weights = {});

/// Replaces the table by its Gaussian kernel density estimate, P(3.15), with the bandwidth P(3.16)
/// of the table's marginals. No mass leaves the table. `scratch` is reused, so that repeated calls
/// do not allocate.
void smooth_gaussian(JointHistogram& histogram, std::vector<double>& scratch);

/// Sets `total` from `mass`, and the reason if a side has one occupied bin or fewer samples than
/// bins.
void update_total(JointHistogram& histogram);

}  // namespace infuse::dependence
