#pragma once

#include <array>
#include <cstdint>

#include "drivers/measurement/stamp.hpp"

namespace infuse::velodyne {

/// Place of a packet among the packets before it, by its counter.
enum class Arrival : uint8_t {
  kFirst,      ///< no packet to compare with
  kNext,       ///< newer than all others
  kLate,       ///< between the two newest
  kTooLate,    ///< older than these
  kDuplicate,  ///< received before
  kClockJump,  ///< the device's clock has jumped
};

/// Orders packets by the device's counter, and distinguishes a late packet from a counter that was
/// set by a restart or by GPS lock.
class ArrivalOrder {
 public:
  struct Verdict {
    Arrival arrival = Arrival::kFirst;
    int64_t delay_us = 0;  ///< counter minus that of the newest packet
  };

  /// Adds a packet by its counter (µs in the hour) and its arrival time.
  Verdict add(uint32_t counter_us, Stamp host);

 private:
  bool is_recent(uint32_t counter_us) const;
  void add_recent(uint32_t counter_us);

  static constexpr size_t kMaxRecent = 16;
  std::array<uint32_t, kMaxRecent> recent_{};
  size_t recent_count_ = 0;  ///< number of packets remembered so far; the ring holds the latest
  uint32_t newest_ = 0;
  uint32_t second_newest_ = 0;
  Stamp newest_host_;
};

}  // namespace infuse::velodyne
