#pragma once

#include <array>
#include <cstdint>

#include "drivers/measurement/stamp.hpp"

namespace infuse::velodyne {

/// What the counter of a packet says of its place among those that came before.
enum class Arrival : uint8_t {
  kFirst,      ///< nothing to compare with
  kNext,       ///< newer than all
  kLate,       ///< between the two newest
  kTooLate,    ///< older than these
  kDuplicate,  ///< came before
  kClockJump,  ///< the device's clock has jumped
};

/// Puts packets in order by the device's counter, and tells a late packet from a counter that was
/// set: by restart, or when GPS took it over.
class ArrivalOrder {
 public:
  struct Verdict {
    Arrival arrival = Arrival::kFirst;
    int64_t delay_us = 0;  ///< counter minus the newest packet's
  };

  /// Takes a packet's counter (µs in the hour) and its time of arrival.
  Verdict add(uint32_t counter_us, Stamp host);

 private:
  bool is_recent(uint32_t counter_us) const;
  void add_recent(uint32_t counter_us);

  static constexpr size_t kMaxRecent = 16;
  std::array<uint32_t, kMaxRecent> recent_{};
  size_t recent_count_ = 0;  ///< remembered so far; the ring holds the last of them
  uint32_t newest_ = 0;
  uint32_t second_newest_ = 0;
  Stamp newest_host_;
};

}  // namespace infuse::velodyne
