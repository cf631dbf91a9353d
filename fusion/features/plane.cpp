#include "fusion/features/plane.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "drivers/measurement/simd.hpp"

namespace infuse::features {
namespace {

/// Weights of a Gaussian from its centre outwards, out to three sigma; the two sides sum to 1.
void make_half_kernel(double sigma, std::vector<float>& kernel) {
  kernel.clear();
  if (sigma <= 0) return kernel.push_back(1.0F);
  const auto weight = [&](int k) { return std::exp(-0.5 * k * k / (sigma * sigma)); };
  const int last = static_cast<int>(std::ceil(3 * sigma));
  double sum = 0;
  for (int k = 0; k <= last; ++k) sum += (k == 0 ? 1 : 2) * weight(k);
  for (int k = 0; k <= last; ++k) kernel.push_back(static_cast<float>(weight(k) / sum));
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
  const float* centre = plane.row(v);
  for (int u = 0; u < plane.width; ++u) out[u] = kernel[0] * centre[u];
  for (int k = 1; k < static_cast<int>(kernel.size()); ++k) {
    add_pair(kernel[static_cast<size_t>(k)], plane.row(v - k), plane.row(v + k), 1, plane.width,
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

}  // namespace

void Plane::resize_like(const Plane& other) {
  width = other.width;
  height = other.height;
  step = other.step;
  values.resize(other.values.size());
}

const float* Plane::row(int v) const {
  return values.data() +
         static_cast<size_t>(std::clamp(v, 0, height - 1)) * static_cast<size_t>(width);
}

float* Plane::row(int v) {
  return values.data() +
         static_cast<size_t>(std::clamp(v, 0, height - 1)) * static_cast<size_t>(width);
}

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

void reduce_by_means(const CameraFrame& grey, int step, Plane& plane) {
  plane.width = grey.width / step;
  plane.height = grey.height / step;
  plane.step = 1;
  plane.values.assign(static_cast<size_t>(plane.width) * static_cast<size_t>(plane.height), 0.0F);
  const float scale = 1.0F / static_cast<float>(step * step);
  for (int v = 0; v < plane.height; ++v) {
    float* out = plane.row(v);
    for (int dv = 0; dv < step; ++dv) {
      const uint8_t* pixel =
          grey.pixels.data() + static_cast<size_t>(v * step + dv) * static_cast<size_t>(grey.width);
      for (int u = 0; u < plane.width; ++u) {
        int sum = 0;
        for (int du = 0; du < step; ++du) sum += *pixel++;
        out[u] += static_cast<float>(sum);
      }
    }
    for (int u = 0; u < plane.width; ++u) out[u] *= scale;
  }
}

void Blur::compute(const Plane& plane, double sigma, int step, Plane& out) {
  const int thin = step / plane.step;
  if (plane.values.empty() || (sigma <= 0 && thin == 1)) {
    out = plane;
    return;
  }
  make_half_kernel(sigma / plane.step, kernel_);
  const auto border = static_cast<int>(kernel_.size());
  out.width = (plane.width - 1) / thin + 1;
  out.height = (plane.height - 1) / thin + 1;
  out.step = step;
  const auto width = static_cast<size_t>(out.width);
  const size_t size = width * static_cast<size_t>(out.height);
  line_.resize(static_cast<size_t>(plane.width + 2 * border));
  float* inner = line_.data() + border;
  out.values.clear();
  out.values.reserve(size);
  for (int v = 0; v < out.height; ++v) {
    blur_columns(plane, v * thin, kernel_, inner);
    std::fill(line_.data(), inner, inner[0]);
    std::fill(inner + plane.width, inner + plane.width + border, inner[plane.width - 1]);
    out.values.resize(out.values.size() + width);  // row by row: while it is in the cache
    blur_row(inner, thin, kernel_, out.width, &out.values[out.values.size() - width]);
  }
}

Plane blurred(const Plane& plane, double sigma, int step) {
  Plane out;
  Blur().compute(plane, sigma, step, out);
  return out;
}

}  // namespace infuse::features
