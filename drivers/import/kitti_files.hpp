#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drivers/import/import_files.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"
#include "drivers/recording/numbered_files.hpp"

namespace infuse::importers {

using recording::NumberedFiles;

/// Lists the files NUMBER.extension of a folder, by number. Empty if the folder does not exist.
NumberedFiles list_files(const std::filesystem::path& folder, const std::string& extension);

/// The same of images: PNG or JPEG.
NumberedFiles list_images(const std::filesystem::path& folder);

/// Reads a file with one stamp per line: seconds since the start (odometry), or
/// "2011-09-26 13:02:25.964389445" (raw, interpreted as UTC). Line k belongs to file number k; an
/// empty line is a missing frame.
Result<std::vector<std::optional<Stamp>>> read_kitti_times(const std::filesystem::path& path);

/// Median of the time from one frame to the next, up to a second; 0 if there is none.
Duration usual_period(const std::vector<std::optional<Stamp>>& times);

/// Assigns stamps to files by number. Files without a stamp are skipped and noted.
std::vector<StampedFile> assign_times(const NumberedFiles& files,
                                      const std::vector<std::optional<Stamp>>& times,
                                      std::vector<Error>& notes);

/// Reads lines of `count` numbers each. Errors contain file and line.
Result<std::vector<std::vector<double>>> read_number_lines(const std::filesystem::path& path,
                                                           size_t count);

}  // namespace infuse::importers
