#include <algorithm>
#include <cmath>

#include "fusion/watch/quick_view.hpp"

namespace infuse::watch {
namespace {

constexpr size_t kLevels = 1024;

}  // namespace

void QuickPicture::set(const CameraFrame& grey, int step) {
  step_ = std::max(1, step);
  width_ = grey.width / step_;
  height_ = grey.height / step_;
  reduce(grey);
  find_edges();
  rank(grey_);
  rank(edge_);
  smooth(grey_);
  smooth(edge_);
}

void QuickPicture::reduce(const CameraFrame& frame) {
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

void QuickPicture::find_edges() {
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

/// Replaces values of 0 … 1 by their rank, 0 … 1.
void QuickPicture::rank(std::vector<float>& plane) {
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
void QuickPicture::smooth(std::vector<float>& plane) {
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

}  // namespace infuse::watch
