#pragma once

#include <filesystem>
#include <optional>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/sweep.hpp"

namespace infuse::recording {

/// File formats of exported sweeps.
enum class SweepFormat {
  kPcd,  ///< Point Cloud Library, binary: all fields
  kPly,  ///< Stanford polygon, binary little-endian: all fields
  kCsv,  ///< text with a header: all fields
  kBin,  ///< KITTI: float32 x y z reflectance
};

/// Returns the format for the extension of `path` (.pcd, .ply, .csv, .bin), or nothing.
std::optional<SweepFormat> detect_sweep_format(const std::filesystem::path& path);

/// Writes a sweep with the fields x, y, z, range (m), reflectivity (0 … 1; named "intensity" in PCD
/// and PLY, as viewers expect), ring, column, time_offset_ns (if `has_times`), return_kind (the
/// numbers of `ReturnKind`). PCD and PLY files contain the sweep's stamp in a comment.
Result<void> export_sweep(const Sweep& sweep, const std::filesystem::path& path,
                          SweepFormat format);

}  // namespace infuse::recording
