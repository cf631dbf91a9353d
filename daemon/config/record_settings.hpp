#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// How a live daemon records what its sensors say, and how much of it. The `[record]` table of the
/// configuration.
struct RecordSettings {
  std::string directory;  ///< where drives are made; empty: `drives` in the state directory
  uint64_t memory = uint64_t{64} << 20;  ///< bytes of what was heard last, kept for the disk
  Duration flight_recorder{
      0};  ///< what of the time before an alert is written with it; 0: no alert is
  Duration after_alert{5'000'000'000};       ///< and of the time after
  uint32_t keep_alerts = 10;                 ///< drives of alerts; the oldest beyond are removed
  Duration max_duration{3'600'000'000'000};  ///< of one recording
  uint64_t max_bytes = uint64_t{16} << 30;   ///< bytes of one recording, all its drives together
  Duration split{0};                         ///< after which another drive is begun; 0: none
  uint64_t split_bytes = 0;                  ///< the same by size; 0: none
  uint64_t min_free = uint64_t{512} << 20;   ///< bytes that are left free on the disk

  /// What is wrong with the numbers, or nothing.
  std::optional<std::string> invalid() const;

  bool operator==(const RecordSettings&) const = default;
};

}  // namespace infuse::daemon
