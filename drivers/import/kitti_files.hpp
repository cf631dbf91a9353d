#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "drivers/import/kitti_layouts.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::recording {

/// NUMBER.extension of a folder, by number; empty where the folder does not exist.
std::map<size_t, std::filesystem::path> list_numbered_files(const std::filesystem::path& folder,
                                                            const std::string& extension);

/// A file of one time a line: seconds since the start (odometry) or "2011-09-26 13:02:25.964389445"
/// (raw, taken as UTC).
Result<std::vector<Stamp>> read_kitti_times(const std::filesystem::path& path);

/// Puts files and times together by number; what has no time is left out and noted.
std::vector<StampedFile> assign_times(const std::map<size_t, std::filesystem::path>& files,
                                      const std::vector<Stamp>& times, std::vector<Error>& notes);

/// Lines of numbers, each of `count`; fails with file and line.
Result<std::vector<std::vector<double>>> read_number_lines(const std::filesystem::path& path,
                                                           size_t count);

}  // namespace infuse::recording
