#include "drivers/lidar/firing_plan.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace infuse::lidar {
namespace {

constexpr int64_t kMaxJumpNs = 1'000'000'000;  // one turn per second

/// Sets the times of the sequences after the last jump by the following packet. Where packets are
/// missing between, its azimuth shows how long they took, but for whole turns, which the rate
/// does.
void retime_after_jump(FiringPlan& plan, const FollowingPacket& following, double rate,
                       const SequenceTiming& timing) {
  const size_t first = plan.last_jump;
  const auto behind = static_cast<int64_t>(plan.count - first);
  const int advance = azimuth_advance(plan.last().azimuth, following.azimuth);
  int64_t start = following.delay_ns - behind * timing.period_ns;
  if (advance > timing.max_step) {
    if (rate <= 0) return;
    const double sequences = std::round(advance / rate / static_cast<double>(timing.period_ns));
    start -= (static_cast<int64_t>(sequences) - 1) * timing.period_ns;
    const double turn_ns = kCentidegreesPerTurn / rate;
    const auto late_ns = static_cast<double>(start - plan.sequences[first].time_ns);
    start -= static_cast<int64_t>(std::round(late_ns / turn_ns) * turn_ns);
  }
  const int64_t earliest = plan.sequences[first - 1].time_ns + timing.period_ns;
  if (start < earliest || start - earliest > kMaxJumpNs) return;
  for (size_t i = first; i < plan.count; ++i) {
    plan.sequences[i].time_ns = start + static_cast<int64_t>(i - first) * timing.period_ns;
  }
}

}  // namespace

void plan_firings(std::span<const uint16_t> azimuths,
                  const std::optional<FollowingPacket>& following, int previous_step, double rate,
                  const SequenceTiming& timing, FiringPlan& plan) {
  plan.count = azimuths.size();
  int step = std::clamp(previous_step, 0, timing.max_step);
  plan.last_jump = 0;
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
        plan.last_jump = i;
        if (rate > 0) {
          now.time_ns = before.time_ns + std::llround(now.advance / rate);
        } else if (step > 0) {
          now.time_ns += (now.advance - step) * timing.period_ns / step;
        }
      }
    }
    if (i + 1 < plan.count) {
      const int advance = azimuth_advance(now.azimuth, azimuths[i + 1]);
      if (advance <= timing.max_step) step = std::max(advance, 0);
    }
    now.step = static_cast<uint16_t>(step);
  }
  if (!following) return;

  if (plan.last_jump > 0) retime_after_jump(plan, *following, rate, timing);
  PlannedSequence& last = plan.sequences[plan.count - 1];
  const int64_t gap_ns = following->delay_ns - (last.time_ns + timing.period_ns);
  const int advance = azimuth_advance(last.azimuth, following->azimuth);
  if (std::abs(gap_ns) <= timing.period_ns / 2 && advance <= timing.max_step) {
    last.step = static_cast<uint16_t>(std::max(advance, 0));
  }
}

}  // namespace infuse::lidar
