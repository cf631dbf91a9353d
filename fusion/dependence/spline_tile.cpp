#include "fusion/dependence/spline_tile.hpp"

#include <algorithm>
#include <bit>
#include <limits>

namespace infuse::dependence {
namespace {

constexpr size_t kChunk = 1024;       // samples that are binned at once
constexpr size_t kChunksPerFold = 8;  // float sums of at most 8192 samples

Float4 broadcast(float value) { return Float4{value, value, value, value}; }

/// The four cubic B-spline weights at the fraction f of a knot interval; they sum to 1.
Float4 spline_weights(float f) {
  constexpr Float4 c3 = {-1.0F / 6, 0.5F, -0.5F, 1.0F / 6}, c2 = {0.5F, -1, 0.5F, 0},
                   c1 = {-0.5F, 0, 0.5F, 0}, c0 = {1.0F / 6, 4.0F / 6, 1.0F / 6, 0};
  const Float4 u = broadcast(f);
  return ((c3 * u + c2) * u + c1) * u + c0;
}

/// Their derivatives with respect to f; they sum to 0.
Float4 spline_slopes(float f) {
  constexpr Float4 c2 = {-0.5F, 1.5F, -1.5F, 0.5F}, c1 = {1, -2, 1, 0}, c0 = {-0.5F, 0, 0.5F, 0};
  const Float4 u = broadcast(f);
  return (c2 * u + c1) * u + c0;
}

/// Where the samples of a chunk lie along y.
struct Chunk {
  alignas(64) int32_t block[kChunk];
  alignas(64) float fraction[kChunk];
  alignas(64) float inside[kChunk];  ///< 1 where the sample moves the table, else 0
};

struct YAxis {
  float low, scale, intervals;
  int32_t absent_block;
};

/// What a chunk's samples are like.
struct Seen {
  int32_t present = 0, bad = 0;  ///< counts; bad: not a number or −∞
  /// Least and greatest place along y of those present, as bits: a float ≥ 0 sorts like them.
  int32_t least = std::numeric_limits<int32_t>::max(), greatest = -1;
};

/// Bins `count` samples.
__attribute__((target_clones("arch=x86-64-v4", "avx2", "default"))) Seen locate(
    const float* moving, const int32_t* first_block, size_t count, const YAxis& axis,
    Chunk& chunk) {
  const YAxis a = axis;
  Seen seen;
  for (size_t i = 0; i < count; ++i) {
    const float y = moving[i];
    const bool absent = y == kAbsent;
    seen.bad += static_cast<int32_t>(!(y > -kAbsent));
    const float t = (y - a.low) * a.scale;
    float clamped = t > 0 ? t : 0;  // takes NaN to 0
    clamped = clamped < a.intervals ? clamped : a.intervals;
    int32_t interval = static_cast<int32_t>(clamped);
    const auto last = static_cast<int32_t>(a.intervals) - 1;
    interval = interval < last ? interval : last;
    chunk.fraction[i] = clamped - static_cast<float>(interval);
    chunk.inside[i] = t == clamped ? 1.0F : 0.0F;
    chunk.block[i] = absent ? a.absent_block : first_block[i] + interval;
    seen.present += static_cast<int32_t>(!absent);
    const auto place = std::bit_cast<int32_t>(clamped);
    seen.least = std::min(seen.least, absent ? seen.least : place);
    seen.greatest = std::max(seen.greatest, absent ? seen.greatest : place);
  }
  return seen;
}

void add_chunk(const Chunk& chunk, const Float4* weights, size_t count, Float4* blocks) {
  for (size_t i = 0; i < count; ++i) {
    const Float4 x = weights[i], y = spline_weights(chunk.fraction[i]);
    Float4* block = blocks + 4 * static_cast<size_t>(chunk.block[i]);
    block[0] += broadcast(x[0]) * y;
    block[1] += broadcast(x[1]) * y;
    block[2] += broadcast(x[2]) * y;
    block[3] += broadcast(x[3]) * y;
  }
}

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
  double least = intervals_x_, greatest = 0;
  for (size_t i = 0; i < fixed.size(); ++i) {
    const double t = std::clamp((static_cast<double>(fixed[i]) - options.x.low) * scale, 0.0,
                                static_cast<double>(intervals_x_));
    least = std::min(least, t);
    greatest = std::max(greatest, t);
    const int32_t interval = std::min(static_cast<int32_t>(t), intervals_x_ - 1);
    weights_[i] = spline_weights(static_cast<float>(t - interval)) *
                  broadcast(weights.empty() ? 1.0F : weights[i]);
    first_block_[i] = interval * intervals_y_;
  }
  fixed_is_constant_ = !(least < greatest);
  blocks_.resize(4 * (static_cast<size_t>(intervals_x_) * static_cast<size_t>(intervals_y_) + 1));
}

void SplineTile::accumulate(std::span<const float> moving, JointHistogram& histogram) {
  const YAxis axis{low_, scale_, static_cast<float>(intervals_y_), intervals_x_ * intervals_y_};
  std::fill(blocks_.begin(), blocks_.end(), Float4{});
  Chunk chunk;
  Seen all;
  size_t chunks = 0;
  for (size_t begin = 0; begin < moving.size(); begin += kChunk) {
    const size_t count = std::min(kChunk, moving.size() - begin);
    const Seen seen =
        locate(moving.data() + begin, first_block_.data() + begin, count, axis, chunk);
    if (seen.bad) {
      histogram.reason = "a sample is not a number";
      return;
    }
    all.least = std::min(all.least, seen.least);
    all.greatest = std::max(all.greatest, seen.greatest);
    histogram.samples += seen.present;
    add_chunk(chunk, weights_.data() + begin, count, blocks_.data());
    if (++chunks % kChunksPerFold == 0) fold(histogram);
  }
  fold(histogram);
  summarise(histogram);
  const bool constant = fixed_is_constant_ || all.least == all.greatest;
  if (histogram.usable() && constant) histogram.reason = kConstantSide;
}

void SplineTile::fold(JointHistogram& histogram) {
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

  const YAxis axis{low_, scale_, static_cast<float>(intervals_y_), intervals_x_ * intervals_y_};
  const auto factor = static_cast<float>(scale * static_cast<double>(scale_));
  Chunk chunk;
  for (size_t begin = 0; begin < moving.size(); begin += kChunk) {
    const size_t count = std::min(kChunk, moving.size() - begin);
    locate(moving.data() + begin, first_block_.data() + begin, count, axis, chunk);
    for (size_t i = 0; i < count; ++i) {
      const Float4 x = weights_[begin + i];
      const Float4* cell = blocks_.data() + 4 * static_cast<size_t>(chunk.block[i]);
      const Float4 along_y = (broadcast(x[0]) * cell[0] + broadcast(x[1]) * cell[1]) +
                             (broadcast(x[2]) * cell[2] + broadcast(x[3]) * cell[3]);
      const Float4 terms = along_y * spline_slopes(chunk.fraction[i]);
      gradient[begin + i] =
          ((terms[0] + terms[2]) + (terms[1] + terms[3])) * (chunk.inside[i] * factor);
    }
  }
}

}  // namespace infuse::dependence
