#include "fusion/features/relative_reflectivity.hpp"

#include <algorithm>
#include <bit>

namespace infuse::features {
namespace {

constexpr uint32_t kReflectivityLevels = 256;  // reflectivities are bytes in the manuals
constexpr uint32_t kRanges = 4 * 8;  // two bits for quarters, three for octaves from 1 m on
constexpr uint32_t kRings = 256;     // bounds memory: no lidar has more; further ones share groups

/// Two bits of a float's mantissa follow its exponent: together they count quarters of octaves.
uint32_t range_group(float range) {
  const auto quarter = [](float value) { return std::bit_cast<uint32_t>(value) >> 21; };
  const float farthest = 255;
  return quarter(std::min(farthest, std::max(1.0F, range))) - quarter(1.0F);
}

/// The comparisons hold for no NaN, which ends as 0.
uint32_t level(float reflectivity) {
  const float part = std::min(1.0F, std::max(0.0F, reflectivity));
  return static_cast<uint32_t>(part * (kReflectivityLevels - 1) + 0.5F);
}

}  // namespace

const std::vector<float>& RelativeReflectivity::compute(std::span<const uint16_t> ring,
                                                        std::span<const float> range,
                                                        std::span<const float> reflectivity) {
  const uint32_t last = ring.empty() ? 0U : *std::max_element(ring.begin(), ring.end());
  const size_t groups = size_t{std::min(last + 1, kRings)} * kRanges;
  size_.assign(groups, 0U);
  if (count_.size() < groups * kReflectivityLevels) count_.resize(groups * kReflectivityLevels, 0U);
  rank_.resize(count_.size());
  cell_.resize(ring.size());
  relative_.resize(ring.size());
  for (size_t i = 0; i < ring.size(); ++i) {
    const uint32_t group = (ring[i] % kRings) * kRanges + range_group(range[i]);
    cell_[i] = group * kReflectivityLevels + level(reflectivity[i]);
    ++count_[cell_[i]];
    ++size_[group];
  }
  for (size_t group = 0; group < groups; ++group) {
    if (size_[group] == 0) continue;
    const float scale = 1.0F / static_cast<float>(size_[group]);
    uint32_t below = 0;
    for (size_t k = group * kReflectivityLevels; k < (group + 1) * kReflectivityLevels; ++k) {
      rank_[k] = scale * (static_cast<float>(below) + 0.5F * static_cast<float>(count_[k]));
      below += count_[k];
      count_[k] = 0;
    }
  }
  for (size_t i = 0; i < cell_.size(); ++i) relative_[i] = rank_[cell_[i]];
  return relative_;
}

}  // namespace infuse::features
