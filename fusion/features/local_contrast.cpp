#include "fusion/features/local_contrast.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/measurement/simd.hpp"

namespace infuse::features {
namespace {

/// Row `first` + `fraction` of a thinner plane, its last sample once more at the end.
void interpolate_row(const Plane& thin, int first, float fraction, std::vector<float>& out) {
  const float* above = thin.row(first);
  const float* below = thin.row(first + 1);
  const auto width = static_cast<size_t>(thin.width);
  out.resize(width + 2);
  for (size_t u = 0; u < width; ++u) out[u] = above[u] + fraction * (below[u] - above[u]);
  out[width] = out[width + 1] = out[width - 1];
}

/// Samples relative to the mean and mean square around them, which are given at the samples of a
/// thinner row.
INFUSE_SIMD_CLONES void normalize_row(const float* __restrict in, const float* __restrict mean,
                                      const float* __restrict power, const int* __restrict first,
                                      const float* __restrict fraction, float min_variance,
                                      int samples, float* __restrict out) {
  for (int u = 0; u < samples; ++u) {
    const int at = first[u];
    const float m = mean[at] + fraction[u] * (mean[at + 1] - mean[at]);
    const float square = power[at] + fraction[u] * (power[at + 1] - power[at]);
    const float variance = square - m * m;
    const float off = in[u] - m;
    const float z2 = off * off / ((variance > 0.0F ? variance : 0.0F) + min_variance);
    const float half = 0.5F * std::sqrt(z2 / (1.0F + z2));
    out[u] = off < 0.0F ? 0.5F - half : 0.5F + half;
  }
}

}  // namespace

void LocalContrast::Interpolation::resize(int samples, float scale) {
  first.resize(static_cast<size_t>(samples));
  fraction.resize(first.size());
  for (size_t i = 0; i < first.size(); ++i) {
    const float position = static_cast<float>(i) * scale;
    first[i] = static_cast<int>(position);
    fraction[i] = position - static_cast<float>(first[i]);
  }
}

/// Thins the plane after the first part of the blur: the rest is cheap.
void LocalContrast::blur_in_two_steps(const Plane& plane, double sigma, int step, Plane& out) {
  const double first = step > plane.step ? 0.75 * step : 0;
  blur_.compute(plane, first, step, thin_);
  blur_.compute(thin_, std::sqrt(sigma * sigma - first * first), step, out);
}

void LocalContrast::compute(const Plane& plane, double width, double noise_sigma, Plane& out) {
  // Means change slowly: a few samples a width are enough.
  const int step = plane.step * std::max(1, static_cast<int>(width / (4 * plane.step)));
  squared_.resize_like(plane);
  for (size_t i = 0; i < plane.values.size(); ++i) {
    squared_.values[i] = plane.values[i] * plane.values[i];
  }
  blur_in_two_steps(plane, width, step, mean_);
  blur_in_two_steps(squared_, width, step, power_);
  out.resize_like(plane);
  const float scale = static_cast<float>(plane.step) / static_cast<float>(step);
  along_.resize(plane.width, scale);
  down_.resize(plane.height, scale);
  const auto min_variance = static_cast<float>(noise_sigma * noise_sigma);
  for (int v = 0; v < plane.height; ++v) {
    const auto at = static_cast<size_t>(v);
    interpolate_row(mean_, down_.first[at], down_.fraction[at], means_);
    interpolate_row(power_, down_.first[at], down_.fraction[at], powers_);
    normalize_row(plane.row(v), means_.data(), powers_.data(), along_.first.data(),
                  along_.fraction.data(), min_variance, plane.width, out.row(v));
  }
}

Plane normalize_local_contrast(const Plane& plane, double width, double noise_sigma) {
  Plane out;
  LocalContrast().compute(plane, width, noise_sigma, out);
  return out;
}

}  // namespace infuse::features
