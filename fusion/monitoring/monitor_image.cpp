#include <algorithm>
#include <cmath>

#include "fusion/monitoring/monitor_view.hpp"

namespace infuse::monitoring {
namespace {

constexpr size_t kLevels = 1024;
constexpr int kContrastRadius = 12;  // samples to each side that a grey level is compared with
constexpr double kNoiseSigma = 2.0 / 255;  // a smooth surface's

}  // namespace

void MonitorImage::build(const CameraFrame& grey, int step) {
  step_ = std::max(1, step);
  width_ = grey.width / step_;
  height_ = grey.height / step_;
  reduce(grey);
  find_edges();
  normalize_local_contrast();
  rank(grey_);
  rank(edge_);
  smooth(grey_);
  smooth(edge_);
}

void MonitorImage::reduce(const CameraFrame& frame) {
  const auto width = static_cast<size_t>(width_);
  grey_.resize(width * static_cast<size_t>(height_));
  sums_.resize(width);
  const float scale = 1.0F / static_cast<float>(step_ * step_ * 256);
  for (int v = 0; v < height_; ++v) {
    std::fill(sums_.begin(), sums_.end(), 0U);
    for (int dv = 0; dv < step_; ++dv) {
      const uint8_t* row = frame.pixels.data() +
                           static_cast<size_t>(v * step_ + dv) * static_cast<size_t>(frame.width);
      for (size_t u = 0; u < width; ++u) {
        for (int du = 0; du < step_; ++du) sums_[u] += *row++;
      }
    }
    float* out = grey_.data() + static_cast<size_t>(v) * width;
    for (size_t u = 0; u < width; ++u) out[u] = scale * static_cast<float>(sums_[u]);
  }
}

void MonitorImage::find_edges() {
  edge_.assign(grey_.size(), 0.0F);
  const auto width = static_cast<size_t>(width_);
  for (int v = 1; v + 1 < height_; ++v) {
    const float* here = grey_.data() + static_cast<size_t>(v) * width;
    float* out = edge_.data() + static_cast<size_t>(v) * width;
    for (size_t u = 1; u + 1 < width; ++u) {
      const float across = std::abs(here[u + 1] - here[u - 1]);
      const float down = std::abs(here[u + width] - here[u - width]);
      out[u] = std::max(across, down);
    }
  }
}

/// Grey against mean and deviation of the square of samples around it, brought to 0 … 1.
void MonitorImage::normalize_local_contrast() {
  const int width = width_ + 1;
  integral_.assign(2 * static_cast<size_t>(width) * static_cast<size_t>(height_ + 1), 0.0);
  const auto sums = [&](int u, int v) { return integral_.data() + 2 * (v * width + u); };
  const float* in = grey_.data();
  for (int v = 0; v < height_; ++v) {
    double sum = 0, squares = 0;
    for (int u = 0; u < width_; ++u) {
      const double grey = *in++;
      sum += grey;
      squares += grey * grey;
      const double* above = sums(u + 1, v);
      double* here = sums(u + 1, v + 1);
      here[0] = above[0] + sum;
      here[1] = above[1] + squares;
    }
  }
  float* out = grey_.data();
  for (int v = 0; v < height_; ++v) {
    const int top = std::max(v - kContrastRadius, 0),
              bottom = std::min(v + kContrastRadius + 1, height_);
    for (int u = 0; u < width_; ++u, ++out) {
      const int left = std::max(u - kContrastRadius, 0),
                right = std::min(u + kContrastRadius + 1, width_);
      const double *a = sums(left, top), *b = sums(right, top), *c = sums(left, bottom),
                   *d = sums(right, bottom);
      const double n = (right - left) * (bottom - top);
      const double mean = (d[0] - b[0] - c[0] + a[0]) / n;
      const double variance = std::max(0.0, (d[1] - b[1] - c[1] + a[1]) / n - mean * mean);
      const double away = *out - mean;
      const double z2 = away * away / (variance + kNoiseSigma * kNoiseSigma);
      const double half = 0.5 * std::sqrt(z2 / (1 + z2));
      *out = static_cast<float>(away < 0 ? 0.5 - half : 0.5 + half);
    }
  }
}

/// Replaces values of 0 … 1 by their rank, 0 … 1.
void MonitorImage::rank(std::vector<float>& plane) {
  std::array<uint32_t, kLevels> count{};
  const auto level = [](float value) {
    return std::min(static_cast<size_t>(value * kLevels), kLevels - 1);
  };
  for (const float value : plane) ++count[level(value)];
  std::array<float, kLevels> rank{};
  double below = 0;
  for (size_t i = 0; i < kLevels; ++i) {
    rank[i] = static_cast<float>((below + 0.5 * count[i]) / static_cast<double>(plane.size()));
    below += count[i];
  }
  for (float& value : plane) value = rank[level(value)];
}

/// Binomial, 1 4 6 4 1 both ways: σ of one sample.
void MonitorImage::smooth(std::vector<float>& plane) {
  scratch_.resize(plane.size());
  const auto width = static_cast<size_t>(width_);
  const auto height = static_cast<size_t>(height_);
  if (width < 5 || height < 5) return;
  const auto weigh = [](float a, float b, float c, float d, float e) {
    return 0.0625F * (a + e) + 0.25F * (b + d) + 0.375F * c;
  };
  for (size_t v = 0; v < height; ++v) {
    const float* in = plane.data() + v * width;
    float* out = scratch_.data() + v * width;
    for (size_t u = 2; u + 2 < width; ++u) {
      out[u] = weigh(in[u - 2], in[u - 1], in[u], in[u + 1], in[u + 2]);
    }
    out[0] = out[1] = out[2];
    out[width - 1] = out[width - 2] = out[width - 3];
  }
  for (size_t v = 0; v < height; ++v) {
    const auto row = [&](size_t at) {
      return scratch_.data() + std::min(at < 2 ? 0 : at - 2, height - 1) * width;
    };
    const float *a = row(v), *b = row(v + 1), *c = row(v + 2), *d = row(v + 3), *e = row(v + 4);
    float* out = plane.data() + v * width;
    for (size_t u = 0; u < width; ++u) out[u] = weigh(a[u], b[u], c[u], d[u], e[u]);
  }
}

}  // namespace infuse::monitoring
