#include "drivers/velodyne/arrival_order.hpp"

#include <algorithm>
#include <cstdlib>

#include "drivers/velodyne/packet.hpp"

namespace infuse::velodyne {
namespace {

/// Maximum reordering delay on a network.
constexpr int64_t kMaxReorderDelayUs = 50'000;
/// Tolerance between the device's and the host's clock for the time between two packets.
constexpr int64_t kClockToleranceUs = 500'000;

}  // namespace

ArrivalOrder::Verdict ArrivalOrder::add(uint32_t counter_us, Stamp host) {
  const auto accept = [&](Arrival arrival, int64_t delay_us) {
    second_newest_ = arrival == Arrival::kNext ? newest_ : counter_us;
    newest_ = counter_us;
    newest_host_ = host;
    add_recent(counter_us);
    return Verdict{arrival, delay_us};
  };
  if (recent_count_ == 0) return accept(Arrival::kFirst, 0);
  const int64_t delay_us = counter_difference_us(counter_us, newest_);
  if (is_recent(counter_us)) return {Arrival::kDuplicate, delay_us};
  if (delay_us <= 0 && delay_us > -kMaxReorderDelayUs) {
    if (counter_difference_us(counter_us, second_newest_) <= 0) {
      return {Arrival::kTooLate, delay_us};
    }
    second_newest_ = counter_us;
    add_recent(counter_us);
    return {Arrival::kLate, delay_us};
  }
  const int64_t host_us = (host - newest_host_).count() / 1000;
  const bool clocks_agree = delay_us > 0 && std::abs(delay_us - host_us) < kClockToleranceUs;
  return accept(clocks_agree ? Arrival::kNext : Arrival::kClockJump, delay_us);
}

bool ArrivalOrder::is_recent(uint32_t counter_us) const {
  const auto* end = recent_.data() + std::min(recent_count_, kMaxRecent);
  return std::find(recent_.data(), end, counter_us) != end;
}

void ArrivalOrder::add_recent(uint32_t counter_us) {
  recent_[recent_count_++ % kMaxRecent] = counter_us;
}

}  // namespace infuse::velodyne
