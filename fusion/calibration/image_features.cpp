#include "fusion/calibration/image_features.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace infuse::calibration {
namespace {

constexpr size_t kLevels = 256;

Plane like(const Plane& plane) {
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

/// One row of the plane, smoothed down its columns.
void blur_columns(const Plane& plane, int v, const std::vector<float>& kernel, float* out) {
  const float* centre = row(plane, v);
  for (int u = 0; u < plane.width; ++u) out[u] = kernel[0] * centre[u];
  for (int k = 1; k < static_cast<int>(kernel.size()); ++k) {
    const float* above = row(plane, v - k);
    const float* below = row(plane, v + k);
    const float weight = kernel[static_cast<size_t>(k)];
    for (int u = 0; u < plane.width; ++u) out[u] += weight * (above[u] + below[u]);
  }
}

/// Every `thin`-th sample of a row, smoothed along it; `line` has `kernel.size()` more at both
/// ends.
void blur_row(const float* line, int thin, const std::vector<float>& kernel, int samples,
              float* out) {
  for (int i = 0; i < samples; ++i) out[i] = kernel[0] * line[i * thin];
  for (int k = 1; k < static_cast<int>(kernel.size()); ++k) {
    const float weight = kernel[static_cast<size_t>(k)];
    for (int i = 0; i < samples; ++i) out[i] += weight * (line[i * thin - k] + line[i * thin + k]);
  }
}

/// Where a sample lies between those of a thinner row.
struct Between {
  int first, second;
  float part;
};

Between between(int at, float scale, int size) {
  const float place = std::min(static_cast<float>(at) * scale, static_cast<float>(size - 1));
  const int first = std::min(static_cast<int>(place), size - 1);
  return {first, std::min(first + 1, size - 1), place - static_cast<float>(first)};
}

float blend(const float* above, const float* below, const Between& along, float down) {
  const int a = along.first, b = along.second;
  const float upper = above[a] + along.part * (above[b] - above[a]);
  const float lower = below[a] + along.part * (below[b] - below[a]);
  return upper + down * (lower - upper);
}

}  // namespace

Plane grey_plane(const CameraFrame& frame) {
  Plane grey{.width = frame.width, .height = frame.height, .values = {}};
  grey.values.resize(static_cast<size_t>(frame.width) * static_cast<size_t>(frame.height));
  const auto step = static_cast<size_t>(channels(frame.format));
  for (size_t i = 0; i < grey.values.size(); ++i) {
    const uint8_t* pixel = &frame.pixels[step * i];
    // Weights in 1/2^14, rounded.
    const int level =
        step == 1 ? pixel[0] : (1868 * pixel[0] + 9617 * pixel[1] + 4899 * pixel[2] + 8192) >> 14;
    grey.values[i] = static_cast<float>(level);
  }
  return grey;
}

Plane edge_strength(const Plane& grey) {
  Plane edge = like(grey);
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
  out.values.resize(static_cast<size_t>(out.width) * static_cast<size_t>(out.height));
  std::vector<float> line(static_cast<size_t>(plane.width + 2 * border));
  float* inner = line.data() + border;
  for (int v = 0; v < out.height; ++v) {
    blur_columns(plane, v * thin, kernel, inner);
    std::fill(line.data(), inner, inner[0]);
    std::fill(inner + plane.width, inner + plane.width + border, inner[plane.width - 1]);
    blur_row(inner, thin, kernel, out.width, &out.values[static_cast<size_t>(v * out.width)]);
  }
  return out;
}

Plane against_surroundings(const Plane& plane, double width, double floor) {
  // Means change slowly: a few samples a width are enough.
  const int step = plane.step * std::max(1, static_cast<int>(width / (4 * plane.step)));
  Plane squared = like(plane);
  for (size_t i = 0; i < squared.values.size(); ++i) {
    squared.values[i] = plane.values[i] * plane.values[i];
  }
  const Plane mean = blurred(plane, width, step);
  const Plane power = blurred(squared, width, step);
  const float scale = static_cast<float>(plane.step) / static_cast<float>(step);
  const auto least = static_cast<float>(floor * floor);
  Plane out = like(plane);
  std::vector<Between> along;
  for (int u = 0; u < plane.width; ++u) along.push_back(between(u, scale, mean.width));
  for (int v = 0; v < plane.height; ++v) {
    const Between down = between(v, scale, mean.height);
    const float* in = row(plane, v);
    float* to = out.values.data() + static_cast<size_t>(v) * static_cast<size_t>(plane.width);
    const float *mean_above = row(mean, down.first), *mean_below = row(mean, down.second);
    const float *power_above = row(power, down.first), *power_below = row(power, down.second);
    for (size_t u = 0; u < along.size(); ++u) {
      const float m = blend(mean_above, mean_below, along[u], down.part);
      const float variance = blend(power_above, power_below, along[u], down.part) - m * m;
      const float z2 = (in[u] - m) * (in[u] - m) / (std::max(variance, 0.0F) + least);
      const float half = 0.5F * std::sqrt(z2 / (1 + z2));
      to[u] = in[u] < m ? 0.5F - half : 0.5F + half;
    }
  }
  return out;
}

}  // namespace infuse::calibration
