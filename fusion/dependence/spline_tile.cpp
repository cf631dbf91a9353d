#include "fusion/dependence/spline_tile.hpp"

#include <algorithm>

namespace infuse::dependence {
namespace {

constexpr size_t kChunksPerFlush = 8;  // sums of at most 8192 samples in single precision

}  // namespace

SplineTile::SplineTile(std::span<const float> fixed, std::span<const float> weights,
                       const JointHistogramOptions& options)
    : weights_(fixed.size()),
      first_block_(fixed.size()),
      intervals_x_(options.x.bins - 3),
      intervals_y_(options.y.bins - 3),
      low_(static_cast<float>(options.y.low)),
      scale_(static_cast<float>(intervals_y_ / (options.y.high - options.y.low))) {
  const double scale = intervals_x_ / (options.x.high - options.x.low);
  double min_place = intervals_x_, max_place = 0;
  for (size_t i = 0; i < fixed.size(); ++i) {
    const double t = std::clamp((static_cast<double>(fixed[i]) - options.x.low) * scale, 0.0,
                                static_cast<double>(intervals_x_));
    min_place = std::min(min_place, t);
    max_place = std::max(max_place, t);
    const int32_t interval = std::min(static_cast<int32_t>(t), intervals_x_ - 1);
    weights_[i] =
        spline_weights(static_cast<float>(t - interval)) * (weights.empty() ? 1.0F : weights[i]);
    first_block_[i] = interval * intervals_y_;
  }
  fixed_is_constant_ = !(min_place < max_place);
  blocks_.resize(4 * (static_cast<size_t>(intervals_x_) * static_cast<size_t>(intervals_y_) + 1));
}

SplineAxis SplineTile::axis() const {
  return {low_, scale_, static_cast<float>(intervals_y_), intervals_x_ * intervals_y_};
}

void SplineTile::accumulate(std::span<const float> moving, JointHistogram& histogram) {
  std::fill(blocks_.begin(), blocks_.end(), Float4{});
  SplineChunk chunk;
  SplineChunkStats all;
  size_t chunks = 0;
  for (size_t begin = 0; begin < moving.size(); begin += kSplineChunkSize) {
    const size_t count = std::min(kSplineChunkSize, moving.size() - begin);
    const SplineChunkStats stats =
        locate_samples(moving.data() + begin, first_block_.data() + begin, count, axis(), chunk);
    if (stats.invalid) {
      histogram.reason = "a sample is not a number";
      return;
    }
    all.min_place = std::min(all.min_place, stats.min_place);
    all.max_place = std::max(all.max_place, stats.max_place);
    histogram.samples += stats.present;
    add_to_blocks(chunk, weights_.data() + begin, count, blocks_.data());
    if (++chunks % kChunksPerFlush == 0) flush_blocks(histogram);
  }
  flush_blocks(histogram);
  update_total(histogram);
  const bool constant = fixed_is_constant_ || all.min_place == all.max_place;
  if (histogram.usable() && constant) histogram.reason = kConstantSide;
}

void SplineTile::flush_blocks(JointHistogram& histogram) {
  const auto bins_y = static_cast<size_t>(histogram.bins_y);
  Float4* block = blocks_.data();
  for (int32_t x = 0; x < intervals_x_; ++x) {
    for (int32_t y = 0; y < intervals_y_; ++y, block += 4) {
      double* corner = histogram.mass.data() + static_cast<size_t>(x) * bins_y + y;
      for (size_t row = 0; row < 4; ++row) {
        for (size_t column = 0; column < 4; ++column) {
          corner[row * bins_y + column] += static_cast<double>(block[row][column]);
        }
        block[row] = Float4{};
      }
    }
  }
}

void SplineTile::differentiate(std::span<const double> table, double scale,
                               std::span<const float> moving, std::span<float> gradient) {
  const auto bins_y = static_cast<size_t>(intervals_y_) + 3;
  Float4* block = blocks_.data();
  for (int32_t x = 0; x < intervals_x_; ++x) {
    for (int32_t y = 0; y < intervals_y_; ++y, block += 4) {
      const double* corner = table.data() + static_cast<size_t>(x) * bins_y + y;
      for (size_t row = 0; row < 4; ++row) {
        for (size_t column = 0; column < 4; ++column) {
          block[row][column] = static_cast<float>(corner[row * bins_y + column]);
        }
      }
    }
  }
  std::fill(block, block + 4, Float4{});  // absent samples

  const auto factor = static_cast<float>(scale * static_cast<double>(scale_));
  SplineChunk chunk;
  for (size_t begin = 0; begin < moving.size(); begin += kSplineChunkSize) {
    const size_t count = std::min(kSplineChunkSize, moving.size() - begin);
    locate_samples(moving.data() + begin, first_block_.data() + begin, count, axis(), chunk);
    differentiate_blocks(chunk, weights_.data() + begin, count, blocks_.data(), factor,
                         gradient.data() + begin);
  }
}

}  // namespace infuse::dependence
