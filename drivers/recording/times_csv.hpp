#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::recording {

/// One file of a numbered sequence.
struct SequenceEntry {
  Stamp stamp;
  size_t number = 0;  ///< NNNNNN
  std::filesystem::path path;
};

/// A folder of files NNNNNN.<extension> with their times.
struct FileSequence {
  std::vector<SequenceEntry> entries;  ///< by number; numbers that have no file are left out
  std::vector<Error> notes;            ///< missing files, files without a time, times going back
};

/// Reads a times.csv: a header line that names the columns, one of them `stamp_ns` (integers); row
/// k (from 0) belongs to file number k. At most ten million rows. A last row that is no number and
/// has no end is left out: a power cut has ended it.
Result<std::vector<Stamp>> read_times(const std::filesystem::path& path);

/// Writes a times.csv; where `sources` is not empty, a second column tells where each came from.
Result<void> write_times(const std::filesystem::path& path, const std::vector<Stamp>& stamps,
                         const std::vector<std::string>& sources = {});

/// Lists a folder of NNNNNN.<one of `extensions`> against its times.csv.
Result<FileSequence> index_sequence(const std::filesystem::path& folder,
                                    const std::vector<std::string>& extensions);

/// The pictures of a camera: NNNNNN.png or NNNNNN.jpg.
Result<FileSequence> index_images(const std::filesystem::path& folder);

}  // namespace infuse::recording
