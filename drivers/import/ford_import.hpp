#pragma once

#include <filesystem>
#include <vector>

#include "drivers/import/lcm_import.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::importers {

/// Result of an import.
struct FordImportSummary {
  size_t packets = 0;
  size_t images = 0;
  size_t cameras = 0;
  size_t speeds = 0;
  size_t poses = 0;                  ///< of the truth
  std::vector<LcmChannel> channels;  ///< of the log
  std::vector<Error> notes;          ///< what is assumed, what was not taken
};

/// Converts a trial of the Ford Campus vision and lidar data set (P, appendix C) to a drive; what
/// is taken from where is in FORD.md. Fails without a log of LCM that has packets of a Velodyne
/// lidar. `drive` must not exist or be empty.
Result<FordImportSummary> import_ford(const std::filesystem::path& folder,
                                      const std::filesystem::path& drive);

}  // namespace infuse::importers
