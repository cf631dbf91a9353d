#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "drivers/velodyne/packet.hpp"

namespace infuse::velodyne {

/// The firing cycle of a sensor whose firmware decides it, from the median period of its packets.
class FiringCycle {
 public:
  explicit FiringCycle(const ModelInfo& info) : info_(info) {}

  /// Takes the time from a packet of these returns to the next. Gives the cycle once, when enough
  /// periods are known; periods that cannot be the model's (more than 10 % off) do not count.
  std::optional<Duration> add(int64_t period_us, bool dual_return);

 private:
  static constexpr size_t kPeriods = 255;
  const ModelInfo& info_;
  std::array<Duration, kPeriods> cycles_{};
  size_t count_ = 0;
};

}  // namespace infuse::velodyne
