#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "drivers/import/bag_topics.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::importers {

/// What to take from a recording.
struct BagImportOptions {
  std::set<std::string> topics;             ///< as `select_topics`; empty: all
  std::string vehicle_frame = "base_link";  ///< name of the vehicle frame in the transforms
};

/// Result of an import.
struct BagImportSummary {
  size_t packets = 0;  ///< data and position packets of all lidars
  size_t sweeps = 0;   ///< clouds of all lidars
  size_t images = 0;
  size_t speeds = 0, imu_samples = 0, fixes = 0;
  BagSurvey survey;
  BagSelection selection;
  std::vector<Error> notes;  ///< skipped messages, what is assumed
  /// What a topic has become ("lidar top"); empty if it is not taken.
  std::string use_of(const std::string& topic) const;
};

/// Converts recordings of ROS (`list_bags`), which are read one after the other, to a drive. Stamps
/// are those of the messages' headers; a message without one has its log time. Packets are written
/// to a capture for each lidar, clouds to PCD files, images as they are or as PNG. `drive` must not
/// exist or be empty.
Result<BagImportSummary> import_bags(const std::vector<std::filesystem::path>& paths,
                                     const std::filesystem::path& drive,
                                     const BagImportOptions& options);

}  // namespace infuse::importers
