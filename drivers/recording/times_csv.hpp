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
  size_t number = 0;  ///< number in the file name
  std::filesystem::path path;
};

/// Files NNNNNN.<extension> of a folder with their stamps.
struct FileSequence {
  std::vector<SequenceEntry> entries;  ///< by number, without the numbers that have no file
  std::vector<Error> notes;  ///< missing files, files without a stamp, stamps that decrease
};

/// Reads a times.csv: a header line that names the columns, one of them `stamp_ns` (integers). Row
/// k (from 0) belongs to file number k. At most ten million rows. A last row that is not a number
/// and has no line end is ignored: it was truncated by a power cut.
Result<std::vector<Stamp>> read_times(const std::filesystem::path& path);

/// Writes a times.csv. If `sources` is not empty, a second column `source` contains it.
Result<void> write_times(const std::filesystem::path& path, const std::vector<Stamp>& stamps,
                         const std::vector<std::string>& sources = {});

/// Lists the files NNNNNN.<one of `extensions`> of a folder with the stamps of its times.csv.
Result<FileSequence> index_sequence(const std::filesystem::path& folder,
                                    const std::vector<std::string>& extensions);

/// Lists a folder of images: NNNNNN.png or NNNNNN.jpg, and times.csv.
Result<FileSequence> index_images(const std::filesystem::path& folder);

}  // namespace infuse::recording
