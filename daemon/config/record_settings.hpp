#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// Settings of recordings: the `[record]` table of the configuration. Live only.
struct RecordSettings {
  std::string directory;  ///< folder of new drives; empty: `drives` in the state directory
  uint64_t memory = uint64_t{64} << 20;  ///< bytes of memory for data not yet on disk
  Duration flight_recorder{0};           ///< span written from before an alert; 0: alerts are not
                                         ///< recorded
  Duration after_alert{5'000'000'000};   ///< span written from after an alert
  uint32_t keep_alerts = 10;             ///< maximum number of alert drives; older ones are removed
  Duration alert_pause{600'000'000'000};     ///< span in which an alert that is raised again is not
                                             ///< recorded again
  uint64_t budget = uint64_t{64} << 30;      ///< maximum size of all recordings together, bytes
  Duration max_duration{3'600'000'000'000};  ///< maximum duration of one recording
  uint64_t max_bytes = uint64_t{16} << 30;   ///< maximum size of one recording, all its drives
  Duration split{0};                         ///< duration at which a new drive begins; 0: none
  uint64_t split_bytes = 0;                  ///< size at which a new drive begins; 0: none
  uint64_t min_free = uint64_t{512} << 20;   ///< minimum free disk space, bytes

  /// Returns what is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;

  bool operator==(const RecordSettings&) const = default;
};

}  // namespace infuse::daemon
