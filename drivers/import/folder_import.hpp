#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/import/folder_stamps.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/recording/drive.hpp"

namespace infuse::importers {

/// What a description of a folder states: a drive.toml whose cameras, and lidars with sweeps, have
/// a `stamps` table each.
struct FolderDescription {
  recording::DriveDescription drive;
  std::vector<std::optional<StampRule>> lidars;  ///< one per lidar; nothing for packets
  std::vector<StampRule> cameras;                ///< one per camera
  toml::table table;                             ///< without the `stamps`: for the lines of errors
};

/// Parses a description. Errors have file and line.
Result<FolderDescription> parse_folder(std::string_view text, const std::string& file);

/// Result of an import.
struct FolderImportSummary {
  size_t packets = 0;  ///< data packets of all lidars
  size_t sweeps = 0;
  size_t images = 0;
  std::vector<Error> notes;  ///< what is left out, what is assumed
};

/// Converts files that a description names to a drive. Paths are relative to the description's
/// folder and must stay inside it. Captures, sweeps and images are checked before anything is
/// written: packets of a lidar on the port, images of the stated size, and some within the
/// time of the lidars. `drive` must not exist or be empty.
Result<FolderImportSummary> import_folder(const std::filesystem::path& description,
                                          const std::filesystem::path& drive);

}  // namespace infuse::importers
