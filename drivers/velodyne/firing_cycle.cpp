#include "drivers/velodyne/firing_cycle.hpp"

#include <chrono>

namespace infuse::velodyne {

std::optional<Duration> FiringCycle::add(int64_t period_us, bool dual_return) {
  if (count_ == kPeriods) return std::nullopt;
  const auto cycles = static_cast<int64_t>(info_.sequences(dual_return)) * info_.firings;
  const Duration cycle = Duration(std::chrono::microseconds(period_us)) / cycles;
  if (std::chrono::abs(cycle - info_.cycle) > info_.cycle / 10) return std::nullopt;
  sum_ += cycle;
  if (++count_ < kPeriods) return std::nullopt;
  return sum_ / kPeriods;
}

}  // namespace infuse::velodyne
