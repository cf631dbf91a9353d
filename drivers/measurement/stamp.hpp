#pragma once

#include <chrono>
#include <compare>
#include <cstdint>
#include <limits>

namespace infuse {

/// A span of time: int64 nanoseconds.
using Duration = std::chrono::nanoseconds;

/// A point in time on infuse's single time base: int64 nanoseconds, the monotonic clock plus an
/// epoch offset fixed at start, so that a step of the wall clock never reorders measurements. In a
/// replay, the recording's own time. A strong type: it combines only with `Duration`.
///
/// Arithmetic saturates at the ends of the range instead of overflowing, since stamps come from
/// files.
class Stamp {
 public:
  constexpr Stamp() = default;
  static constexpr Stamp from_ns(int64_t ns) { return Stamp(ns); }  ///< since the Unix epoch
  /// Before all.
  static constexpr Stamp earliest() { return Stamp(std::numeric_limits<int64_t>::min()); }
  /// After all others.
  static constexpr Stamp latest() { return Stamp(std::numeric_limits<int64_t>::max()); }

  /// Nanoseconds since the Unix epoch.
  constexpr int64_t ns() const { return ns_; }

  constexpr auto operator<=>(const Stamp&) const = default;  ///< by time

  /// Later by a span; saturates.
  friend constexpr Stamp operator+(Stamp stamp, Duration span) {
    int64_t sum = 0;
    if (__builtin_add_overflow(stamp.ns_, span.count(), &sum)) {
      return span.count() > 0 ? latest() : earliest();
    }
    return Stamp(sum);
  }
  /// The span between two; saturates.
  friend constexpr Duration operator-(Stamp later, Stamp earlier) {
    int64_t difference = 0;
    if (__builtin_sub_overflow(later.ns_, earlier.ns_, &difference)) {
      return later > earlier ? Duration::max() : Duration::min();
    }
    return Duration(difference);
  }
  /// Earlier by a span; saturates.
  friend constexpr Stamp operator-(Stamp stamp, Duration span) {
    return span == Duration::min() ? latest() : stamp + (-span);
  }
  constexpr Stamp& operator+=(Duration span) { return *this = *this + span; }  ///< saturates
  constexpr Stamp& operator-=(Duration span) { return *this = *this - span; }  ///< saturates

 private:
  explicit constexpr Stamp(int64_t ns) : ns_(ns) {}
  int64_t ns_ = 0;
};

/// Absolute difference of two stamps; saturates.
constexpr Duration distance_between(Stamp a, Stamp b) { return a < b ? b - a : a - b; }

/// Seconds as a double: for text, settings and arithmetic inside a function, never across an
/// interface.
constexpr double to_seconds(Duration span) { return static_cast<double>(span.count()) * 1e-9; }

/// The nearest nanosecond; saturates, and maps NaN to zero.
constexpr Duration from_seconds(double seconds) {
  constexpr double kLimit = 9.2e18;
  const double ns = seconds * 1e9;
  if (!(ns == ns)) return Duration::zero();
  if (ns >= kLimit) return Duration::max();
  if (ns <= -kLimit) return Duration::min();
  return Duration(static_cast<int64_t>(ns + (ns < 0 ? -0.5 : 0.5)));
}

}  // namespace infuse
