#pragma once

#include <optional>

#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// Generates a tick for each second of drive time. Depends on the stamps alone.
class DriveTicker {
 public:
  static constexpr Duration kPeriod{1'000'000'000};
  /// Maximum number of ticks in a pause; one more follows at its end. A clock that jumps by a year
  /// must not cause a year of ticks.
  static constexpr int kMaxTicks = 30;
  /// Step back beyond which drive time begins anew; less is disorder between streams.
  static constexpr Duration kMaxDisorder{1'000'000'000};

  /// Calls `tick(Stamp)` for every second that has passed at the next event's stamp.
  template <class Tick>
  void advance(Stamp stamp, Tick tick) {
    if (!next_ || stamp + kMaxDisorder < *next_ - kPeriod) {
      next_ = stamp + kPeriod;
      return;
    }
    for (int ticks = 0; stamp >= *next_ && ticks <= kMaxTicks; ++ticks) {
      if (ticks == kMaxTicks) *next_ += (stamp - *next_) / kPeriod * kPeriod;
      tick(*next_);
      *next_ += kPeriod;
    }
  }

 private:
  std::optional<Stamp> next_;
};

}  // namespace infuse::daemon
