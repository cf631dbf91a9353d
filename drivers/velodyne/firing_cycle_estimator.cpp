#include "drivers/velodyne/firing_cycle_estimator.hpp"

#include <chrono>

namespace infuse::velodyne {

std::optional<Duration> FiringCycleEstimator::add(int64_t period_us, bool dual_return) {
  if (count_ == kPeriodsToAverage) return std::nullopt;
  const auto cycles = static_cast<int64_t>(info_.sequences_per_packet(dual_return)) * info_.firings;
  const Duration cycle = Duration(std::chrono::microseconds(period_us)) / cycles;
  if (std::chrono::abs(cycle - info_.cycle) > info_.cycle / 10) return std::nullopt;
  sum_ += cycle;
  if (++count_ < kPeriodsToAverage) return std::nullopt;
  return sum_ / kPeriodsToAverage;
}

}  // namespace infuse::velodyne
