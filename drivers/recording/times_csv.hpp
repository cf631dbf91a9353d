#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::recording {

/// Times of one sweep or image.
struct TimesRow {
  Stamp stamp;                    ///< as recorded; of a sweep: the begin of its turn
  std::optional<Stamp> end;       ///< end of the sweep's turn
  std::optional<Stamp> exposure;  ///< middle of the image's exposure, where it is known better
                                  ///< than by the camera's delay
};

/// One file of a numbered sequence.
struct SequenceEntry {
  Stamp stamp;        ///< begin of the sweep's turn; middle of the image's exposure
  Duration span{0};   ///< of a sweep; 0 if it is not known
  size_t number = 0;  ///< number in the file name
  std::filesystem::path path;
};

/// Files NNNNNN.<extension> of a folder with their stamps.
struct FileSequence {
  std::vector<SequenceEntry> entries;  ///< by number, without the numbers that have no file
  std::vector<Error> notes;  ///< missing files, files without a stamp, stamps that decrease
};

/// Reads a times.csv: a header line that names the columns, one of them `stamp_ns`; `end_ns` and
/// `exposure_ns` are optional, and may be empty in a row (integers). Row k (from 0) belongs to file
/// number k. At most ten million rows. A last row that is not a number and has no line end is
/// ignored: it was truncated by a power cut.
Result<std::vector<TimesRow>> read_times(const std::filesystem::path& path);

/// Writes a times.csv, with the optional columns that a row has. If `sources` is not empty, a last
/// column `source` contains it.
Result<void> write_times(const std::filesystem::path& path, const std::vector<TimesRow>& rows,
                         const std::vector<std::string>& sources = {});

/// Writes a times.csv of stamps alone.
Result<void> write_times(const std::filesystem::path& path, const std::vector<Stamp>& stamps);

/// Lists a folder of decoded sweeps: NNNNNN.bin or NNNNNN.pcd, and times.csv. A sweep whose end is
/// not given, or is not within `kMaxTurn` after its stamp, spans the usual time between two.
Result<FileSequence> index_sweeps(const std::filesystem::path& folder);

/// Maximum span of a sweep.
inline constexpr Duration kMaxTurn{2'000'000'000};

/// Lists a folder of images: NNNNNN.png or NNNNNN.jpg, and times.csv. The middle of an exposure is
/// the stamp minus `stamp_delay`, unless the row states it.
Result<FileSequence> index_images(const std::filesystem::path& folder,
                                  Duration stamp_delay = Duration::zero());

}  // namespace infuse::recording
