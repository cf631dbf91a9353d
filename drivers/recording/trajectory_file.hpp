#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::recording {

/// One line of a trajectory file.
struct TrajectoryPose {
  Stamp stamp;  ///< index of the pose in nanoseconds if the format has no stamps (KITTI)
  Eigen::Isometry3d T_frame_body = Eigen::Isometry3d::Identity();  ///< the pose
};

/// Parses a trajectory in TUM format: "seconds x y z qx qy qz qw" per line. Empty lines and lines
/// that begin with # are skipped. Fails with the line number if a line is not eight finite numbers,
/// the norm of the quaternion is not 1 (within 1 %), or stamps do not increase.
Result<std::vector<TrajectoryPose>> parse_tum(std::string_view text, const std::string& name);

/// Parses a trajectory in KITTI odometry format: twelve numbers per line, the upper three rows of a
/// 4 × 4 pose by row. Fails with the line number if a line is not twelve finite numbers or not a
/// rigid motion (within 1 %; the rotation is normalised).
Result<std::vector<TrajectoryPose>> parse_kitti(std::string_view text, const std::string& name);

/// Reads a file of at most 1 GiB in TUM or KITTI format, detected by the count of numbers in its
/// first line.
Result<std::vector<TrajectoryPose>> read_trajectory(const std::filesystem::path& file);

/// Formats a trajectory in TUM format: stamps in nanosecond, positions in micrometre resolution.
std::string format_tum(const std::vector<TrajectoryPose>& poses);

/// Formats a trajectory in KITTI odometry format, without stamps.
std::string format_kitti(const std::vector<TrajectoryPose>& poses);

}  // namespace infuse::recording
