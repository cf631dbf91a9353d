#include "drivers/lidar/firing_plan.hpp"

#include <algorithm>
#include <cstdlib>

namespace infuse::lidar {
namespace {

constexpr int64_t kMaxJumpNs = 1'000'000'000;  // one turn per second

/// Sets the times of the sequences after the last jump so that the following packet comes directly
/// after them.
void retime_after_jump(FiringPlan& plan, size_t first, int64_t following_ns, int64_t period_ns) {
  const int64_t start = following_ns - static_cast<int64_t>(plan.count - first) * period_ns;
  const int64_t earliest = plan.sequences[first - 1].time_ns + period_ns;
  if (start < earliest || start - earliest > kMaxJumpNs) return;
  for (size_t i = first; i < plan.count; ++i) {
    plan.sequences[i].time_ns = start + static_cast<int64_t>(i - first) * period_ns;
  }
}

}  // namespace

void plan_firings(std::span<const uint16_t> azimuths,
                  const std::optional<FollowingPacket>& following, int previous_step,
                  const SequenceTiming& timing, FiringPlan& plan) {
  plan.count = azimuths.size();
  int step = std::clamp(previous_step, 0, timing.max_step);
  size_t after_last_jump = 0;
  for (size_t i = 0; i < plan.count; ++i) {
    PlannedSequence& now = plan.sequences[i];
    now = {};
    now.azimuth = azimuths[i];
    if (i > 0) {
      const PlannedSequence& before = plan.sequences[i - 1];
      now.advance = azimuth_advance(before.azimuth, now.azimuth);
      now.after_jump = now.advance > timing.max_step;
      now.time_ns = before.time_ns + timing.period_ns;
      if (now.after_jump) {
        after_last_jump = i;
        if (step > 0) now.time_ns += (now.advance - step) * timing.period_ns / step;
      }
    }
    if (i + 1 < plan.count) {
      const int advance = azimuth_advance(now.azimuth, azimuths[i + 1]);
      if (advance <= timing.max_step) step = std::max(advance, 0);
    }
    now.step = static_cast<uint16_t>(step);
  }
  if (!following) return;

  if (after_last_jump > 0) {
    retime_after_jump(plan, after_last_jump, following->delay_ns, timing.period_ns);
  }
  PlannedSequence& last = plan.sequences[plan.count - 1];
  const int64_t gap_ns = following->delay_ns - (last.time_ns + timing.period_ns);
  const int advance = azimuth_advance(last.azimuth, following->azimuth);
  if (std::abs(gap_ns) <= timing.period_ns / 2 && advance <= timing.max_step) {
    last.step = static_cast<uint16_t>(std::max(advance, 0));
  }
}

}  // namespace infuse::lidar
