#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// What to write of a drive.
struct McapExportOptions {
  std::filesystem::path reports;  ///< of a replay of the drive (`infused --replay`); empty: none
  bool deskew = false;            ///< also write deskewed clouds
};

/// Result of an export.
struct McapExportSummary {
  std::map<std::string, size_t> messages;  ///< by topic
  std::vector<Error> notes;                ///< what was not written
};

/// Writes a drive, or a bare capture, as ROS 2 messages to an MCAP file; the topics are listed in
/// daemon/ros/README.md. The file contains what the drive does and no more: the log time of a
/// message is the time at which the drive has it, its header's stamp the time of measurement.
Result<McapExportSummary> export_mcap(const std::filesystem::path& drive,
                                      const std::filesystem::path& output,
                                      const McapExportOptions& options);

/// Writes the messages of an MCAP file that is cut or damaged, as far as they can be read, to a new
/// file with an index.
Result<McapExportSummary> recover_mcap(const std::filesystem::path& damaged,
                                       const std::filesystem::path& output);

}  // namespace infuse::daemon
