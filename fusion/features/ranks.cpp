#include "fusion/features/ranks.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <vector>

namespace infuse::features {
namespace {

constexpr size_t kRankLevels = 1024;

/// A value and its place.
struct Keyed {
  uint32_t key;  ///< sorts as the float does
  uint32_t index;
};

uint32_t sort_key(float value) {
  const auto bits = std::bit_cast<uint32_t>(value + 0.0F);  // −0 becomes 0
  return (bits & 0x8000'0000U) != 0 ? ~bits : bits | 0x8000'0000U;
}

/// Radix sort, eleven bits at a time.
void sort_by_key(std::vector<Keyed>& keyed) {
  std::vector<Keyed> other(keyed.size());
  for (const int shift : {0, 11, 22}) {
    std::array<uint32_t, 2049> first{};
    const auto digit = [&](const Keyed& k) { return (k.key >> shift) & 2047U; };
    for (const Keyed& k : keyed) ++first[digit(k) + 1];
    for (size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
    for (const Keyed& k : keyed) other[first[digit(k)]++] = k;
    keyed.swap(other);
  }
}

/// Ranks of sorted values, divided by their number.
void assign_ranks(std::span<const Keyed> keyed, std::span<float> values) {
  const auto n = static_cast<double>(keyed.size());
  for (size_t first = 0; first < keyed.size();) {
    size_t last = first;
    while (last < keyed.size() && keyed[last].key == keyed[first].key) ++last;
    const auto shared = static_cast<float>(0.5 * static_cast<double>(first + last - 1) / n);
    for (size_t i = first; i < last; ++i) values[keyed[i].index] = shared;
    first = last;
  }
}

}  // namespace

void equalize(std::span<float> values) {
  std::vector<Keyed> keyed(values.size());
  for (size_t i = 0; i < values.size(); ++i)
    keyed[i] = {sort_key(values[i]), static_cast<uint32_t>(i)};
  sort_by_key(keyed);
  assign_ranks(keyed, values);
}

void equalize_within_groups(std::span<const uint16_t> group, std::span<float> values) {
  std::vector<Keyed> keyed;
  for (size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i])) continue;
    keyed.push_back({sort_key(values[i]), static_cast<uint32_t>(i)});
  }
  sort_by_key(keyed);
  std::stable_sort(keyed.begin(), keyed.end(),
                   [&](const Keyed& a, const Keyed& b) { return group[a.index] < group[b.index]; });
  const std::span<const Keyed> all(keyed);
  for (size_t first = 0; first < all.size();) {
    size_t last = first;
    while (last < all.size() && group[all[last].index] == group[all[first].index]) ++last;
    assign_ranks(all.subspan(first, last - first), values);
    first = last;
  }
}

void equalize_by_level(std::span<float> values, float max_value) {
  const float scale = static_cast<float>(kRankLevels) / max_value;
  const auto level = [&](float value) {
    return std::min(static_cast<size_t>(std::max(value, 0.0F) * scale), kRankLevels - 1);
  };
  std::array<uint32_t, kRankLevels> count{};
  size_t n = 0;
  for (const float value : values) {
    if (std::isnan(value)) continue;
    ++count[level(value)];
    ++n;
  }
  std::array<float, kRankLevels> rank{};
  double below = 0;
  for (size_t i = 0; i < kRankLevels; ++i) {
    rank[i] = static_cast<float>((below + 0.5 * (static_cast<double>(count[i]) - 1)) /
                                 static_cast<double>(std::max<size_t>(n, 1)));
    below += count[i];
  }
  for (float& value : values) {
    if (!std::isnan(value)) value = rank[level(value)];
  }
}

}  // namespace infuse::features
