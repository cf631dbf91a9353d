#pragma once

#include <string_view>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/sweep.hpp"
#include "drivers/recording/pcd_header.hpp"

namespace infuse::recording {

/// Parses the header of a PLY file (Stanford polygon; ascii or binary_little_endian) whose first
/// element is "vertex", as that of the same points in a PCD file. CloudCompare's prefix "scalar_"
/// is left out of names. Faces and other elements that follow the points are ignored. Limits as
/// `parse_pcd_header`; an error's `where` is the line.
Result<PcdHeader> parse_ply_header(std::string_view bytes);

/// Parses the bytes of a PLY file into a sweep, as `parse_pcd_sweep`.
Result<void> parse_ply_sweep(std::string_view bytes, Sweep& sweep);

}  // namespace infuse::recording
