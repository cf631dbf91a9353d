#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "tests/drivers/makers/made_up_maker.hpp"

namespace infuse::made_up {

inline constexpr std::array kElevations{-0.2, -0.1, 0.0, 0.1};  // rad

inline const lidar::LidarModel& model() { return maker().models()[0]; }

/// The packet `index` of a sensor in the middle of a cylinder of this radius, m, that turns ten
/// times a second; the first one fires at `start`.
inline std::vector<uint8_t> packet(uint32_t index, Stamp start, double radius) {
  std::vector<uint8_t> bytes;
  const auto put = [&](uint64_t value, size_t count) {
    for (size_t i = 0; i < count; ++i) bytes.push_back(static_cast<uint8_t>(value >> (8 * i)));
  };
  put(kMark, 4);
  put(index, 4);
  put(static_cast<uint64_t>((start + index * kSequences * kPeriod).ns()), 8);
  for (size_t i = 0; i < kSequences; ++i) {
    put((index * kSequences + i) % 1000 * 36, 2);
    for (const double elevation : kElevations) {
      put(static_cast<uint64_t>(std::lround(radius / std::cos(elevation) * 100)), 2);
    }
  }
  return bytes;
}

}  // namespace infuse::made_up
