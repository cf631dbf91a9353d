#include "fusion/calibration/image_features.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/measurement/simd.hpp"

namespace infuse::calibration {
namespace {

constexpr size_t kLevels = 256;

Plane make_same_size(const Plane& plane) {
  Plane out{.width = plane.width, .height = plane.height, .step = plane.step, .values = {}};
  out.values.resize(plane.values.size());
  return out;
}

const float* row(const Plane& plane, int v) {
  return plane.values.data() +
         static_cast<size_t>(std::clamp(v, 0, plane.height - 1)) * static_cast<size_t>(plane.width);
}

/// A Gaussian's weights from its centre outwards, out to three sigma; the two sides sum to 1.
std::vector<float> half_kernel(double sigma) {
  std::vector<double> weights;
  double sum = 0;
  for (int k = 0; k <= static_cast<int>(std::ceil(3 * sigma)); ++k) {
    weights.push_back(std::exp(-0.5 * k * k / (sigma * sigma)));
    sum += (k == 0 ? 1 : 2) * weights.back();
  }
  std::vector<float> kernel;
  for (const double weight : weights) kernel.push_back(static_cast<float>(weight / sum));
  return kernel;
}

/// out += weight · (one + other), sample by sample; `step`: of `one` and `other`.
INFUSE_SIMD_CLONES void add_pair(float weight, const float* __restrict one,
                                 const float* __restrict other, int step, int samples,
                                 float* __restrict out) {
  if (step == 1) {
    for (int i = 0; i < samples; ++i) out[i] += weight * (one[i] + other[i]);
  } else {
    for (int i = 0; i < samples; ++i) out[i] += weight * (one[i * step] + other[i * step]);
  }
}

/// One row of the plane, smoothed down its columns.
void blur_columns(const Plane& plane, int v, const std::vector<float>& kernel, float* out) {
  const float* centre = row(plane, v);
  for (int u = 0; u < plane.width; ++u) out[u] = kernel[0] * centre[u];
  for (int k = 1; k < static_cast<int>(kernel.size()); ++k) {
    add_pair(kernel[static_cast<size_t>(k)], row(plane, v - k), row(plane, v + k), 1, plane.width,
             out);
  }
}

/// Every `thin`-th sample of a row, smoothed along it; `line` has `kernel.size()` more at both
/// ends.
void blur_row(const float* line, int thin, const std::vector<float>& kernel, int samples,
              float* out) {
  for (int i = 0; i < samples; ++i) out[i] = kernel[0] * line[i * thin];
  for (int k = 1; k < static_cast<int>(kernel.size()); ++k) {
    add_pair(kernel[static_cast<size_t>(k)], line - k, line + k, thin, samples, out);
  }
}

/// Where the samples of a row lie between those of a thinner one: after which, and how far.
struct RowInterpolation {
  std::vector<int> first;
  std::vector<float> fraction;
};

RowInterpolation row_interpolation(int samples, float scale) {
  RowInterpolation all;
  for (int i = 0; i < samples; ++i) {
    const float place = static_cast<float>(i) * scale;
    all.first.push_back(static_cast<int>(place));
    all.fraction.push_back(place - static_cast<float>(all.first.back()));
  }
  return all;
}

/// Row `place` of a thinner plane, between two of its rows, its last sample once more at the end.
void interpolate_row(const Plane& thin, int first, float part, std::vector<float>& out) {
  const float* above = row(thin, first);
  const float* below = row(thin, first + 1);
  const auto width = static_cast<size_t>(thin.width);
  out.resize(width + 2);
  for (size_t u = 0; u < width; ++u) out[u] = above[u] + part * (below[u] - above[u]);
  out[width] = out[width + 1] = out[width - 1];
}

/// Samples against the mean and mean square around them, which are given at the samples of a
/// thinner row.
INFUSE_SIMD_CLONES void normalize_row(const float* __restrict in, const float* __restrict mean,
                                      const float* __restrict power, const int* __restrict first,
                                      const float* __restrict part, float min_variance, int samples,
                                      float* __restrict out) {
  for (int u = 0; u < samples; ++u) {
    const int at = first[u];
    const float m = mean[at] + part[u] * (mean[at + 1] - mean[at]);
    const float square = power[at] + part[u] * (power[at + 1] - power[at]);
    const float spread = square - m * m;
    const float off = in[u] - m;
    const float z2 = off * off / ((spread > 0.0F ? spread : 0.0F) + min_variance);
    const float half = 0.5F * std::sqrt(z2 / (1.0F + z2));
    out[u] = off < 0.0F ? 0.5F - half : 0.5F + half;
  }
}

/// |n · ∇I| of a row, of which there is one more sample on both sides; `right` and `down`: n.
INFUSE_SIMD_CLONES void ring_edge_row(const float* __restrict above, const float* __restrict here,
                                      const float* __restrict below, const float* __restrict right,
                                      const float* __restrict down, int samples,
                                      float* __restrict out) {
  for (int u = 0; u < samples; ++u) {
    const float across =
        above[u + 1] - above[u - 1] + 2 * (here[u + 1] - here[u - 1]) + below[u + 1] - below[u - 1];
    const float downwards =
        below[u - 1] - above[u - 1] + 2 * (below[u] - above[u]) + below[u + 1] - above[u + 1];
    out[u] = 0.25F * std::abs(right[u] * across + down[u] * downwards);
  }
}

/// A row with its first and last sample once more.
void copy_with_border(const Plane& plane, int v, std::vector<float>& out) {
  const float* from = row(plane, v);
  out.resize(static_cast<size_t>(plane.width) + 2);
  out.front() = from[0];
  std::copy_n(from, plane.width, out.begin() + 1);
  out.back() = from[plane.width - 1];
}

/// What the squares of row `v` hold, a sample each; beyond the squares as in the last.
void expand_cells(const RingDirections& rings, const std::vector<float>& values, int v,
                  std::vector<float>& out) {
  const int first = std::min(v / RingDirections::kCellSize, rings.rows - 1) * rings.columns;
  for (size_t u = 0; u < out.size(); ++u) {
    const int column = std::min(static_cast<int>(u) / RingDirections::kCellSize, rings.columns - 1);
    out[u] = values[static_cast<size_t>(first + column)];
  }
}

/// `blurred`, thinned after the first little of it: the rest is cheap.
Plane blur_in_two_steps(const Plane& plane, double sigma, int step) {
  const double first = step > plane.step ? 0.75 * step : 0;
  return blurred(blurred(plane, first, step), std::sqrt(sigma * sigma - first * first), step);
}

}  // namespace

Plane grey_plane(const CameraFrame& frame) {
  Plane grey{.width = frame.width, .height = frame.height, .values = {}};
  grey.values.resize(static_cast<size_t>(frame.width) * static_cast<size_t>(frame.height));
  const auto step = static_cast<size_t>(channels(frame.format));
  for (size_t i = 0; i < grey.values.size(); ++i) {
    const uint8_t* pixel = &frame.pixels[step * i];
    const uint8_t level = step == 1 ? pixel[0] : luminance(pixel[0], pixel[1], pixel[2]);
    grey.values[i] = static_cast<float>(level);
  }
  return grey;
}

Plane edge_strength(const Plane& grey) {
  Plane edge = make_same_size(grey);
  const int width = grey.width;
  std::vector<float> high(static_cast<size_t>(width));
  std::vector<float> low(static_cast<size_t>(width));
  for (int v = 0; v < grey.height; ++v) {
    const float* above = row(grey, v - 1);
    const float* here = row(grey, v);
    const float* below = row(grey, v + 1);
    for (int u = 0; u < width; ++u) {
      const auto at = static_cast<size_t>(u);
      high[at] = std::max(std::max(above[u], here[u]), below[u]);
      low[at] = std::min(std::min(above[u], here[u]), below[u]);
    }
    float* out = edge.values.data() + static_cast<size_t>(v) * static_cast<size_t>(width);
    for (int u = 0; u < width; ++u) {
      const auto left = static_cast<size_t>(std::max(u - 1, 0));
      const auto at = static_cast<size_t>(u);
      const auto right = static_cast<size_t>(std::min(u + 1, width - 1));
      const float highest = std::max(std::max(high[left], high[at]), high[right]);
      const float lowest = std::min(std::min(low[left], low[at]), low[right]);
      out[u] = std::max(highest - here[u], here[u] - lowest);
    }
  }
  return edge;
}

Plane ring_edge(const Plane& grey, const RingDirections& rings) {
  Plane edge = make_same_size(grey);
  const auto width = static_cast<size_t>(grey.width);
  std::vector<float> right(width, 1.0F), down(width, 0.0F);
  std::vector<float> above, here, below;
  for (int v = 0; v < grey.height; ++v) {
    if (rings.columns > 0 && v % RingDirections::kCellSize == 0) {
      expand_cells(rings, rings.right, v, right);
      expand_cells(rings, rings.down, v, down);
    }
    copy_with_border(grey, v - 1, above);
    copy_with_border(grey, v, here);
    copy_with_border(grey, v + 1, below);
    ring_edge_row(above.data() + 1, here.data() + 1, below.data() + 1, right.data(), down.data(),
                  grey.width, edge.values.data() + static_cast<size_t>(v) * width);
  }
  return edge;
}

Plane equalized(Plane plane) {
  std::array<size_t, kLevels> count{};
  const auto level = [](float value) {
    return static_cast<size_t>(std::clamp(value, 0.0F, 255.0F));
  };
  for (const float value : plane.values) ++count[level(value)];
  std::array<float, kLevels> rank{};
  const auto n = static_cast<double>(plane.values.size());
  double below = 0;
  for (size_t i = 0; i < kLevels; ++i) {
    const auto here = static_cast<double>(count[i]);
    rank[i] = static_cast<float>((below + 0.5 * (here - 1)) / n);
    below += here;
  }
  for (float& value : plane.values) value = rank[level(value)];
  return plane;
}

Plane blurred(const Plane& plane, double sigma, int step) {
  const int thin = step / plane.step;
  if (plane.values.empty() || (sigma <= 0 && thin == 1)) return plane;
  const std::vector<float> kernel =
      sigma > 0 ? half_kernel(sigma / plane.step) : std::vector<float>{1.0F};
  const auto border = static_cast<int>(kernel.size());
  Plane out{.width = (plane.width - 1) / thin + 1,
            .height = (plane.height - 1) / thin + 1,
            .step = step,
            .values = {}};
  const auto width = static_cast<size_t>(out.width);
  out.values.reserve(width * static_cast<size_t>(out.height));
  std::vector<float> line(static_cast<size_t>(plane.width + 2 * border));
  float* inner = line.data() + border;
  for (int v = 0; v < out.height; ++v) {
    blur_columns(plane, v * thin, kernel, inner);
    std::fill(line.data(), inner, inner[0]);
    std::fill(inner + plane.width, inner + plane.width + border, inner[plane.width - 1]);
    out.values.resize(out.values.size() + width);  // row by row: while it is in the cache
    blur_row(inner, thin, kernel, out.width, &out.values[out.values.size() - width]);
  }
  return out;
}

Plane normalize_local_contrast(const Plane& plane, double width, double floor) {
  // Means change slowly: a few samples a width are enough.
  const int step = plane.step * std::max(1, static_cast<int>(width / (4 * plane.step)));
  Plane squared = plane;
  for (float& value : squared.values) value *= value;
  const Plane mean = blur_in_two_steps(plane, width, step);
  const Plane power = blur_in_two_steps(squared, width, step);
  const float scale = static_cast<float>(plane.step) / static_cast<float>(step);
  const auto min_variance = static_cast<float>(floor * floor);
  Plane out = make_same_size(plane);
  const RowInterpolation along = row_interpolation(plane.width, scale);
  const RowInterpolation down = row_interpolation(plane.height, scale);
  std::vector<float> means, powers;
  for (int v = 0; v < plane.height; ++v) {
    const auto at = static_cast<size_t>(v);
    interpolate_row(mean, down.first[at], down.fraction[at], means);
    interpolate_row(power, down.first[at], down.fraction[at], powers);
    normalize_row(row(plane, v), means.data(), powers.data(), along.first.data(),
                  along.fraction.data(), min_variance, plane.width,
                  &out.values[at * static_cast<size_t>(plane.width)]);
  }
  return out;
}

}  // namespace infuse::calibration
