#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::recording {

/// Where the vehicle was.
struct StampedPose {
  Stamp stamp;
  Eigen::Isometry3d T_map_vehicle = Eigen::Isometry3d::Identity();
};

/// Writes a trajectory in TUM's format, a line a pose: seconds (nine decimals) tx ty tz qx qy qz
/// qw.
Result<void> write_poses_tum(const std::filesystem::path& path,
                             const std::vector<StampedPose>& poses);

/// Reads one; lines that begin with # are passed over. Stamps are exact to the nanosecond.
Result<std::vector<StampedPose>> read_poses_tum(const std::filesystem::path& path);

}  // namespace infuse::recording
