#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

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
std::optional<SweepFormat> sweep_format(const std::filesystem::path& path);

/// Writes a sweep: x, y, z, range (m), reflectivity (0 … 1), ring, column, time_offset_ns,
/// return_kind; the stamp of the sweep stands in a comment where the format has one.
Result<void> export_sweep(const Sweep& sweep, const std::filesystem::path& path,
                          SweepFormat format);

}  // namespace infuse::recording
