#pragma once

#include <cstdint>

#include "drivers/measurement/stamp.hpp"

namespace infuse::host {

/// The host's two clocks at one moment, ns.
struct ClockReading {
  int64_t monotonic_ns = 0;  ///< CLOCK_MONOTONIC
  int64_t wall_ns = 0;       ///< CLOCK_REALTIME, since the Unix epoch

  /// Reads both clocks: the wall clock between two readings of the monotonic one.
  static ClockReading now();
};

/// infuse's time base when it runs live: the monotonic clock plus an epoch offset fixed at start. A
/// step of the wall clock does not change it.
class TimeBase {
 public:
  /// Fixes the offset so that the stamp of `start` is its wall time.
  explicit TimeBase(const ClockReading& start = ClockReading::now())
      : offset_ns_(start.wall_ns - start.monotonic_ns) {}

  /// Stamp of a monotonic time, as device drivers report it.
  Stamp at_monotonic(int64_t monotonic_ns) const {
    return Stamp::from_ns(monotonic_ns) + Duration(offset_ns_);
  }

  /// Stamp of the current time.
  Stamp now() const { return at_monotonic(ClockReading::now().monotonic_ns); }

 private:
  int64_t offset_ns_;
};

/// Converts the kernel's receive stamps, which are wall times, to the time base by their age. A
/// message received around a step of the wall clock gets the time at which it was read.
class WallStamps {
 public:
  explicit WallStamps(const TimeBase& base) : base_(base) {}

  /// Updates the clocks; call it right after messages were read.
  void update(const ClockReading& now);

  /// Stamp of a message of that read, from the kernel's wall time of it.
  Stamp stamp_of(int64_t wall_ns) const;

  /// Stamp of the last `update`, for messages that the kernel did not stamp.
  Stamp last_update() const { return last_update_; }

  /// Number of steps of the wall clock that were detected.
  uint64_t steps() const { return steps_; }

 private:
  static constexpr int64_t kMinStepNs = 1'000'000;  // ns; a smaller difference is drift
  static constexpr int64_t kDriftDivisor = 1000;    // a slewed clock gains at most 1 ms per second
  static constexpr int64_t kMaxAgeNs = 10'000'000'000;  // ns; no message waits longer to be read

  TimeBase base_;
  ClockReading reading_;
  Stamp last_update_;
  bool has_reading_ = false;
  bool stepped_ = false;
  uint64_t steps_ = 0;
};

}  // namespace infuse::host
