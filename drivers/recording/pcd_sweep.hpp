#pragma once

#include <string_view>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/sweep.hpp"
#include "drivers/recording/pcd_header.hpp"

namespace infuse::recording {

/// The field with the time of each return.
struct TimeField {
  std::string_view name = "time_offset_ns";
  double ns = 1;    ///< nanoseconds of its unit
  double zero = 0;  ///< its value at the sweep's stamp
};

/// Parses the bytes of a PCD file (Point Cloud Library; ascii, binary or binary_compressed; at most
/// 4 million points and 256 MiB) into a sweep. Fields: x, y, z (m, lidar frame); optionally
/// intensity (or reflectivity, reflectance, i), ring (or channel, line, laser_id, laser, beam) and
/// time_offset_ns (after the sweep's stamp). Reflectivity is 0 … 1: intensities are divided by 255
/// if one exceeds 1, by 65535 if one exceeds 255, and clamped to 1.
///
/// Points that are not finite or lie at the origin (directions without a return) are skipped. Rings
/// are renumbered by elevation from below. Returns are sorted by ring from the top, and
/// counter-clockwise from straight ahead within a ring, as KITTI writes its sweeps. Without a ring
/// field, or with more than 128 rings, rings are inferred from the order of the returns
/// (`infer_rings`) or from their elevations (`restore_rings`). Order, rings and columns of a file
/// with all fields of `export_sweep` are kept. `has_times` is true if there is a time of each
/// return and not all are equal; one outside 0 … `kMaxTurn` is an error. Stamp, sequence and clock
/// are left to the caller.
Result<void> parse_pcd_sweep(std::string_view bytes, Sweep& sweep);

/// The same for the points that follow a header, with the times of the field `time`.
Result<void> parse_points(const PcdHeader& header, std::string_view points, Sweep& sweep,
                          const TimeField& time = {});

/// Values of one field of binary points, one per point.
std::vector<double> read_field(const PcdHeader& header, std::string_view points, size_t field);

}  // namespace infuse::recording
