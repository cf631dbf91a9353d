#pragma once

#include <cstdint>

#include "drivers/measurement/stamp.hpp"

namespace infuse::receive {

/// The host's two clocks at one moment, ns.
struct ClockReading {
  int64_t monotonic_ns = 0;  ///< CLOCK_MONOTONIC
  int64_t wall_ns = 0;       ///< CLOCK_REALTIME, since the Unix epoch

  /// Both clocks now: the wall clock between two readings of the monotonic one.
  static ClockReading now();
};

/// infuse's time base when it runs live: the monotonic clock plus an epoch offset fixed at start.
/// A step of the wall clock changes only `utc_offset`.
class TimeBase {
 public:
  /// Fixes the offset so that a stamp of this moment is its wall time.
  explicit TimeBase(const ClockReading& start = ClockReading::now())
      : offset_ns_(start.wall_ns - start.monotonic_ns) {}

  /// The stamp of a monotonic time, as drivers of devices give it.
  Stamp at_monotonic(int64_t monotonic_ns) const {
    return Stamp::from_ns(monotonic_ns) + Duration(offset_ns_);
  }

  /// The stamp of this moment.
  Stamp now() const { return at_monotonic(ClockReading::now().monotonic_ns); }

  /// What is added to a stamp to have the wall clock's time, as the wall clock is at `reading`.
  Duration utc_offset(const ClockReading& reading) const {
    return Duration(reading.wall_ns - reading.monotonic_ns - offset_ns_);
  }

 private:
  int64_t offset_ns_;
};

/// Brings the kernel's receive stamps, which are wall times, onto the time base by their age. What
/// was received around a step of the wall clock is stamped by the time at which it was read.
class WallStamps {
 public:
  explicit WallStamps(const TimeBase& base) : base_(base) {}

  /// Takes the clocks as they are right after messages were read.
  void update(const ClockReading& now);

  /// The stamp of a message of that read, by the kernel's wall time of it.
  Stamp stamp_of(int64_t wall_ns) const;

  /// The stamp of the last `look`, for what the kernel did not stamp.
  Stamp last_update() const { return last_update_; }

  /// Steps of the wall clock that were seen.
  uint64_t steps() const { return steps_; }

 private:
  static constexpr int64_t kMinStepNs = 1'000'000;  // ns; less is drift
  static constexpr int64_t kDriftDivisor = 1000;    // a slewed clock gains at most 1 ms a second
  static constexpr int64_t kMaxAgeNs = 10'000'000'000;  // ns; nothing waits longer to be read

  TimeBase base_;
  ClockReading reading_;
  Stamp last_update_;
  bool has_reading_ = false;
  bool stepped_ = false;
  uint64_t steps_ = 0;
};

}  // namespace infuse::receive
