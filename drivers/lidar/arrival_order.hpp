#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "drivers/measurement/stamp.hpp"

namespace infuse::lidar {

/// Place of a packet among the packets before it, by its counter.
enum class Arrival : uint8_t {
  kFirst,      ///< no packet to compare with
  kNext,       ///< newer than all others
  kLate,       ///< between the two newest
  kTooLate,    ///< older than these
  kDuplicate,  ///< received before
  kClockJump,  ///< the device's clock has jumped
};

/// Difference of two counters of a device that wrap after `modulo` (0: never): within half of it.
constexpr Duration counter_difference(Duration later, Duration earlier, Duration modulo) {
  Duration difference = later - earlier;
  if (difference > modulo / 2) difference -= modulo;
  if (difference < -modulo / 2) difference += modulo;
  return difference;
}

/// Orders packets by the device's counter, and distinguishes a late packet from a counter that was
/// set by a restart or by GPS lock.
class ArrivalOrder {
 public:
  struct Verdict {
    Arrival arrival = Arrival::kFirst;
    Duration delay{0};  ///< counter minus that of the newest packet
  };

  /// `modulo`: time after which the counter wraps; 0: never.
  explicit ArrivalOrder(Duration modulo) : modulo_(modulo) {}

  /// Adds a packet by its counter and its arrival time.
  Verdict add(Duration counter, Stamp host);

 private:
  bool is_recent(Duration counter) const;
  void add_recent(Duration counter);

  static constexpr size_t kMaxRecent = 16;
  Duration modulo_;
  std::array<Duration, kMaxRecent> recent_{};
  size_t recent_count_ = 0;  ///< number of packets remembered so far; the ring holds the latest
  Duration newest_{0};
  Duration second_newest_{0};
  Stamp newest_host_;
};

}  // namespace infuse::lidar
