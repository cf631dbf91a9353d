#include "drivers/lidar/arrival_order.hpp"

#include <algorithm>
#include <cstdlib>

namespace infuse::lidar {
namespace {

/// Maximum reordering delay on a network.
constexpr Duration kMaxReorderDelay{50'000'000};
/// Tolerance between the device's and the host's clock for the time between two packets.
constexpr int64_t kClockToleranceUs = 500'000;

}  // namespace

ArrivalOrder::Verdict ArrivalOrder::add(Duration counter, Stamp host) {
  const auto accept = [&](Arrival arrival, Duration delay) {
    second_newest_ = arrival == Arrival::kNext ? newest_ : counter;
    newest_ = counter;
    newest_host_ = host;
    add_recent(counter);
    return Verdict{arrival, delay};
  };
  if (recent_count_ == 0) return accept(Arrival::kFirst, Duration(0));
  const Duration delay = counter_difference(counter, newest_, modulo_);
  if (is_recent(counter)) return {Arrival::kDuplicate, delay};
  if (delay <= Duration(0) && delay > -kMaxReorderDelay) {
    if (counter_difference(counter, second_newest_, modulo_) <= Duration(0)) {
      return {Arrival::kTooLate, delay};
    }
    second_newest_ = counter;
    add_recent(counter);
    return {Arrival::kLate, delay};
  }
  const int64_t host_us = (host - newest_host_).count() / 1000;
  const bool clocks_agree =
      delay > Duration(0) && std::abs(delay.count() / 1000 - host_us) < kClockToleranceUs;
  return accept(clocks_agree ? Arrival::kNext : Arrival::kClockJump, delay);
}

bool ArrivalOrder::is_recent(Duration counter) const {
  const auto* end = recent_.data() + std::min(recent_count_, kMaxRecent);
  return std::find(recent_.data(), end, counter) != end;
}

void ArrivalOrder::add_recent(Duration counter) { recent_[recent_count_++ % kMaxRecent] = counter; }

}  // namespace infuse::lidar
