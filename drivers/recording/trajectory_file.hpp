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
  Stamp stamp;  ///< the line's number in nanoseconds where the format has no times (KITTI)
  Eigen::Isometry3d T_frame_body = Eigen::Isometry3d::Identity();
};

/// Reads "seconds x y z qx qy qz qw" a line, as the TUM benchmark writes trajectories; lines that
/// begin with # and empty ones are passed over. Fails with the line's number where one is not eight
/// finite numbers, the quaternion is not of length 1 (within 1 %) or time does not rise.
Result<std::vector<TrajectoryPose>> parse_tum(std::string_view text, const std::string& name);

/// Reads twelve numbers a line, the upper three rows of a 4 × 4 pose by row, as KITTI odometry
/// does. Fails with the line's number where one is not twelve finite numbers, or not a rigid motion
/// (within 1 %; rounding is mended).
Result<std::vector<TrajectoryPose>> parse_kitti(std::string_view text, const std::string& name);

/// Reads a file of at most 1 GiB, as TUM or KITTI by how many numbers its first line holds.
Result<std::vector<TrajectoryPose>> read_trajectory(const std::filesystem::path& file);

/// The text `parse_tum` reads: time to the nanosecond, metres to the micrometre.
std::string format_tum(const std::vector<TrajectoryPose>& poses);

/// The text `parse_kitti` reads; the stamps are lost.
std::string format_kitti(const std::vector<TrajectoryPose>& poses);

}  // namespace infuse::recording
