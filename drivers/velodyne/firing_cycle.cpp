#include "drivers/velodyne/firing_cycle.hpp"

#include <algorithm>
#include <numeric>

namespace infuse::velodyne {

std::optional<Duration> FiringCycle::add(int64_t period_us, bool dual_return) {
  if (count_ == kPeriods) return std::nullopt;
  const auto sequences = static_cast<int64_t>(info_.sequences(dual_return));
  const Duration cycle(period_us * 1000 / (sequences * info_.firings));
  if (std::abs((cycle - info_.cycle).count()) > info_.cycle.count() / 10) return std::nullopt;
  cycles_[count_++] = cycle;
  if (count_ < kPeriods) return std::nullopt;
  // The counter has whole microseconds, so periods alternate between two values: the mean of the
  // middle half is between them, the median only on one.
  std::sort(cycles_.begin(), cycles_.end());
  const auto* first = cycles_.data() + kPeriods / 4;
  const auto* last = cycles_.data() + kPeriods - kPeriods / 4;
  return std::accumulate(first, last, Duration(0)) / (last - first);
}

}  // namespace infuse::velodyne
