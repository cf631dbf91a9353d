#pragma once

#include <optional>

#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// Finds the whole seconds of drive time as the stamps of a drive go by. Depends on the stamps
/// alone.
class DriveTicker {
 public:
  static constexpr Duration kPeriod{1'000'000'000};
  /// Of a long pause only so many ticks are given, then one at its end: stamps come from files, and
  /// a clock that jumped by a year must not keep anyone busy.
  static constexpr int kMaxTicks = 30;
  /// A step back by more than this begins drive time anew; less is disorder between streams.
  static constexpr Duration kMaxDisorder{1'000'000'000};

  /// Takes the stamp of the next event and calls `tick(Stamp)` for every second that has passed.
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
