#pragma once

#include <cstdint>
#include <optional>

#include "drivers/velodyne/packet.hpp"

namespace infuse::velodyne {

/// Estimates the firing cycle of a sensor whose firmware determines it, from the period of its
/// packets.
class FiringCycleEstimator {
 public:
  explicit FiringCycleEstimator(const ModelInfo& info) : info_(info) {}

  /// Adds the time from a packet with these returns to the next. Returns the cycle once, when
  /// enough periods are known: the mean, since the counter has whole microseconds only. Periods
  /// more than 10 % off the model's (packets are missing) are ignored.
  std::optional<Duration> add(int64_t period_us, bool dual_return);

 private:
  static constexpr int64_t kPeriodsToAverage = 1024;
  const ModelInfo& info_;
  Duration sum_{0};
  int64_t count_ = 0;
};

}  // namespace infuse::velodyne
