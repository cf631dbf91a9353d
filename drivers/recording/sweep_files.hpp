#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/sweep.hpp"

namespace infuse::recording {

/// Reads decoded sweeps: PCD and PLY files (`parse_pcd_sweep`), or KITTI's .bin files (float32 x y
/// z reflectance, little-endian). Reuses its memory for .bin files.
class SweepReader {
 public:
  /// Fills `sweep` from a .pcd or .ply file with `parse_pcd_sweep`, from any other file as KITTI's
  /// .bin: range is computed, rings are inferred (`infer_rings`, or `restore_rings`), `has_times`
  /// is false, points that are not finite are skipped. Files longer than 64 MiB are errors. Stamp,
  /// sequence and clock are left to the caller.
  Result<void> read(const std::filesystem::path& path, Sweep& sweep);

  /// Reserves memory, so that reading up to `points` points allocates nothing.
  void reserve(size_t points, Sweep& sweep);

 private:
  Result<void> load(const std::filesystem::path& path);
  std::vector<std::array<float, 4>> points_;
};

/// Reads a single sweep as `SweepReader::read`.
Result<void> read_sweep_file(const std::filesystem::path& path, Sweep& sweep);

/// Writes x, y, z and reflectivity as a KITTI .bin file.
Result<void> write_sweep_bin(const std::filesystem::path& path, const Sweep& sweep);

/// Maximum number of rings of a sweep without ring numbers.
inline constexpr size_t kMaxRings = 128;

/// Fills `ring`, `column`, `rings`, `columns` of a sweep whose points are ordered ring by ring from
/// the top, and counter-clockwise from straight ahead within a ring, as in KITTI's HDL-64E sweeps.
/// A new ring begins where the azimuth decreases by more than half a turn. The result is accepted
/// if there are 2 … `kMaxRings` rings and mean elevations decrease from ring to ring (with one
/// exception in ten). Columns are azimuth steps of the usual distance between neighbours on a ring,
/// counted counter-clockwise from straight ahead. Otherwise sets all four to 0 and returns false.
bool infer_rings(Sweep& sweep);

/// As `infer_rings`, for known rings: ring k from the top consists of the points starts[k] …
/// starts[k + 1] − 1, counter-clockwise from straight ahead. Returns false if there are more than
/// `kMaxRings` rings or the column width cannot be determined.
bool assign_rings(Sweep& sweep, std::span<const size_t> starts);

/// Fills the same four for points in any order, and sorts the points ring by ring from the top,
/// counter-clockwise from straight ahead within a ring. A lidar's beams keep their elevations, so
/// the elevations of a sweep that is measured from one position form clusters: accepted are 2 …
/// `kMaxRings` of them that hold nine returns of ten in their middle halves. Returns false and
/// changes nothing otherwise: for a sweep in another frame than the lidar's, one that is merged or
/// strongly deskewed, and for lidars whose beams begin at different heights (HDL-64E). Where
/// clusters are found, but no column width, points are sorted and the four are 0.
bool restore_rings(Sweep& sweep);

}  // namespace infuse::recording
