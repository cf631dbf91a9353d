#pragma once

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/sweep.hpp"
#include "drivers/ros/messages.hpp"

namespace infuse::importers {

/// Converts a cloud to a sweep, whatever lidar made it. x, y, z, intensity and rings are found by
/// name as in PCD files (`recording::parse_points`).
///
/// Times of the returns, by name and type: `t`, `time_offset_ns`, `offset_time`, `time_stamp` in
/// integers are nanoseconds (Ouster, Livox, Autoware); `time`, `time_stamp` in floats are seconds
/// (Velodyne); `timestamp` in doubles is an absolute time, in seconds (Hesai, RoboSense) or
/// nanoseconds (Livox), by its size. Relative times count from `stamp`, where the sweep begins; if
/// some are negative or if they are absolute, it begins at the smallest of them. Without such a
/// field, or where all returns have the same time, `has_times` is false.
///
/// Errors: a big-endian cloud, fields outside a point, times that span more than 2 s.
Result<void> to_sweep(const ros::PointCloud2& cloud, Stamp stamp, Sweep& sweep);

}  // namespace infuse::importers
