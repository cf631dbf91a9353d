#include "fusion/calibration/relative_reflectivity.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::calibration {
namespace {

/// A return, and the beam and range that it is compared within.
struct Keyed {
  uint32_t group;
  float reflectivity;
  uint32_t index;
};

uint32_t group_of(uint16_t ring, float range) {
  constexpr float kGroups = 4;    // of range, a factor of e
  constexpr uint32_t kMost = 64;  // of them; the first holds all within a metre, the last the rest
  const float at = kGroups * std::log(std::max(1.0F, range));
  return ring * kMost + static_cast<uint32_t>(std::min(at, static_cast<float>(kMost - 1)));
}

}  // namespace

std::vector<float> relative_reflectivity(std::span<const uint16_t> ring,
                                         std::span<const float> range,
                                         std::span<const float> reflectivity) {
  std::vector<Keyed> keyed(ring.size());
  for (size_t i = 0; i < keyed.size(); ++i) {
    const float value = std::isnan(reflectivity[i]) ? 0.0F : reflectivity[i];
    keyed[i] = {group_of(ring[i], range[i]), value, static_cast<uint32_t>(i)};
  }
  std::sort(keyed.begin(), keyed.end(), [](const Keyed& a, const Keyed& b) {
    return a.group != b.group ? a.group < b.group : a.reflectivity < b.reflectivity;
  });
  std::vector<float> relative(keyed.size());
  for (size_t begin = 0; begin < keyed.size();) {
    size_t end = begin;
    while (end < keyed.size() && keyed[end].group == keyed[begin].group) ++end;
    for (size_t first = begin; first < end;) {
      size_t last = first;
      while (last < end && keyed[last].reflectivity == keyed[first].reflectivity) ++last;
      const auto rank =
          static_cast<float>(first - begin + last - begin) / static_cast<float>(2 * (end - begin));
      for (; first < last; ++first) relative[keyed[first].index] = rank;
    }
    begin = end;
  }
  return relative;
}

}  // namespace infuse::calibration
