#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::recording {

/// A sweep or a picture and its time.
struct StampedFile {
  Stamp stamp;
  std::filesystem::path path;
};

/// Makes a drive's folder; refuses one that holds something.
Result<void> make_empty_folder(const std::filesystem::path& drive);

/// Hard-links `files` into `folder` as 000000.extension …, copies them where that is not possible,
/// and writes their times.csv.
Result<void> link_sequence(const std::vector<StampedFile>& files,
                           const std::filesystem::path& folder);

}  // namespace infuse::recording
