#pragma once

#include <filesystem>
#include <optional>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/sweep.hpp"

namespace infuse::recording {

/// Formats that a sweep can be exported to.
enum class SweepFormat {
  kPcd,  ///< Point Cloud Library, binary: all fields
  kPly,  ///< Stanford polygon, binary little-endian: all fields
  kCsv,  ///< text with a header: all fields
  kBin,  ///< KITTI: float32 x y z reflectance
};

/// By extension (.pcd, .ply, .csv, .bin), or nothing.
std::optional<SweepFormat> detect_sweep_format(const std::filesystem::path& path);

/// Writes a sweep: x, y, z, range (m), reflectivity (0 … 1; "intensity" in PCD and PLY, the name
/// that viewers know), ring, column, time_offset_ns, return_kind (0 strongest, 1 last, 2 both). The
/// sweep's stamp stands in a comment of PCD and PLY.
Result<void> export_sweep(const Sweep& sweep, const std::filesystem::path& path,
                          SweepFormat format);

}  // namespace infuse::recording
