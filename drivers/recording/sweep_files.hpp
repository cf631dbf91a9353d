#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/sweep.hpp"
#include "drivers/recording/times_csv.hpp"

namespace infuse::recording {

/// Reads decoded sweeps: float32 x y z reflectance, little-endian, as KITTI; or PCD files
/// (`parse_pcd_sweep`), by their extension. Keeps its memory for the former.
class SweepReader {
 public:
  /// Fills `sweep` from a .pcd as `parse_pcd_sweep`, from any other as KITTI's: range is computed,
  /// rings are inferred (`infer_rings`), `has_times` is false. Points that are not finite are left
  /// out; a file longer than 64 MiB is refused. Stamp, sequence and clock are the caller's.
  Result<void> read(const std::filesystem::path& path, Sweep& sweep);

  /// Makes room, so that reading up to `points` allocates nothing.
  void reserve(size_t points, Sweep& sweep);

 private:
  Result<void> load(const std::filesystem::path& path);
  std::vector<std::array<float, 4>> points_;
};

/// The same for a single sweep.
Result<void> read_sweep_file(const std::filesystem::path& path, Sweep& sweep);

/// Writes x, y, z, reflectivity as `read_sweep_file` reads them.
Result<void> write_sweep_bin(const std::filesystem::path& path, const Sweep& sweep);

/// Fills `ring`, `column`, `rings`, `columns` of a sweep whose points come ring after ring from the
/// top, each counter-clockwise from straight ahead, as KITTI writes its HDL-64E: a new ring begins
/// where the azimuth falls by more than half a turn. Believed when that gives 2 … 128 rings whose
/// mean elevations fall from ring to ring (one in ten may not). A column is then a step of azimuth,
/// counted counter-clockwise from straight ahead, as wide as neighbours on a ring are usually
/// apart. Otherwise all four are 0 and the answer is false.
bool infer_rings(Sweep& sweep);

/// The same for a sweep whose rings are known: ring k from the top is points starts[k] …
/// starts[k + 1] − 1, counter-clockwise from straight ahead. False, and nothing, where there are
/// more than 128 or no two neighbours tell how wide a column is.
bool assign_rings(Sweep& sweep, std::span<const size_t> starts);

/// The decoded sweeps of a drive: a folder of NNNNNN.bin or NNNNNN.pcd and times.csv.
Result<FileSequence> index_sweeps(const std::filesystem::path& folder);

}  // namespace infuse::recording
