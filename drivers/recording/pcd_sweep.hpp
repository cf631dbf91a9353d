#pragma once

#include <string_view>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/sweep.hpp"

namespace infuse::recording {

/// Reads a sweep from the bytes of a PCD file (Point Cloud Library; ascii, binary or
/// binary_compressed; at most 4 million points of together 256 MiB) with the fields x, y, z (m,
/// lidar frame) and, where they are there, intensity (or reflectivity, reflectance, i) and ring (or
/// channel, laser, beam). Reflectivity is 0 … 1: of intensities of which one exceeds 1 the 255th
/// part, of which one exceeds 255 the 65535th, 1 at most.
///
/// Points that are not finite or lie at the origin (directions without a return) are left out.
/// Rings are counted anew by elevation from below, and the returns sorted by ring from the top and
/// counter-clockwise from straight ahead within it, as KITTI writes its sweeps; without a ring
/// field, or with more than 128 rings, they stay in their order and rings are inferred
/// (`infer_rings`). `has_times` is false. Stamp, sequence and clock are the caller's.
Result<void> parse_pcd_sweep(std::string_view bytes, Sweep& sweep);

}  // namespace infuse::recording
