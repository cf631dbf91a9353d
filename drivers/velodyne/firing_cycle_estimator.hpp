#pragma once

#include <cstdint>
#include <optional>

#include "drivers/velodyne/packet.hpp"

namespace infuse::velodyne {

/// The firing cycle of a sensor whose firmware decides it, from the period of its packets.
class FiringCycleEstimator {
 public:
  explicit FiringCycleEstimator(const ModelInfo& info) : info_(info) {}

  /// Takes the time from a packet of these returns to the next. Gives the cycle once, when enough
  /// periods are known; periods that cannot be the model's (more than 10 % off: packets are
  /// missing) do not count. The mean of the rest, since the counter has whole microseconds only.
  std::optional<Duration> add(int64_t period_us, bool dual_return);

 private:
  static constexpr int64_t kPeriodsToAverage = 1024;
  const ModelInfo& info_;
  Duration sum_{0};
  int64_t count_ = 0;
};

}  // namespace infuse::velodyne
