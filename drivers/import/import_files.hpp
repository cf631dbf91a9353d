#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/recording/times_csv.hpp"

namespace infuse::importers {

/// A sweep or image file and its times.
struct StampedFile {
  recording::TimesRow times;
  std::filesystem::path path;
  size_t number = 0;  ///< in the data set
};

/// Creates the folder of a drive. Fails if it exists and is not empty.
Result<void> make_empty_folder(const std::filesystem::path& drive);

/// Hard-links a file, or copies it if linking fails; creates the folders above. Nothing is done if
/// the file is there already; another file in its place is an error.
Result<void> link_file(const std::filesystem::path& from, const std::filesystem::path& to);

/// Hard-links `files` into `folder` as 000000.extension …, or copies them if linking fails, and
/// writes times.csv.
Result<void> link_sequence(const std::vector<StampedFile>& files,
                           const std::filesystem::path& folder);

}  // namespace infuse::importers
