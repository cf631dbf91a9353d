#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "drivers/import/bag_topics.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::importers {

/// What logs contain on a channel.
struct LcmChannel {
  std::string name;
  size_t messages = 0;
  size_t smallest = 0, largest = 0;  ///< messages, bytes
  Stamp first, last;                 ///< when they were logged
  bool has_data = false;             ///< data packets of a lidar
  bool has_positions = false;        ///< position packets
  bool has_own_times = false;        ///< a time stands before each packet
  StampLag lag;                      ///< of these times, of the first messages
  std::string use;                   ///< what it has become; empty: it is not taken

  /// Messages per second; 0 if there are less than two, or they have one time.
  double rate_hz() const;
};

/// Result of an import.
struct LcmImportSummary {
  size_t packets = 0;                ///< data and position packets of all lidars
  std::vector<LcmChannel> channels;  ///< by name
  std::vector<Error> notes;          ///< what is damaged, what is assumed
};

/// Converts logs of LCM, which are read one after the other, to a drive. Each channel with data
/// packets of a lidar (`find_packets`) becomes a capture. A packet has the time that
/// stands before it, if in the channel's first messages there is one within 10 s of the time at
/// which the message was logged; else that. Fails if there are no packets, and names the channels.
/// `drive` must not exist or be empty.
Result<LcmImportSummary> import_lcm(const std::vector<std::filesystem::path>& files,
                                    const std::filesystem::path& drive);

}  // namespace infuse::importers
