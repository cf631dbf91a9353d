#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "drivers/import/kitti_sweep_times.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/vehicle_samples.hpp"
#include "drivers/recording/trajectory_file.hpp"

namespace infuse::importers {

/// What KITTI's inertial navigation system measured.
struct KittiOxts {
  std::vector<recording::TrajectoryPose> poses;  ///< T_map_vehicle; positions from satellites
  std::vector<recording::TrajectoryPose> path;   ///< T_odom_vehicle; positions from the velocities,
                                                 ///< which are smoother from sweep to sweep
  std::vector<WheelOdometry> speed;              ///< forward velocity at the vehicle's origin
  std::vector<ImuSample> imu;
  std::vector<GnssFix> gnss;
};

/// Reads oxts/ of the raw layout: data/NUMBER.txt and timestamps.txt. The map frame is
/// east-north-up at the first fix. Rows whose stamp is not after that of the row before are skipped
/// and noted. Errors: a row that cannot be read, stamps of another time zone than the sweeps'.
Result<KittiOxts> read_kitti_oxts(const std::filesystem::path& folder,
                                  const Eigen::Isometry3d& T_imu_vehicle,
                                  const std::vector<std::optional<TurnTimes>>& turns,
                                  std::vector<Error>& notes);

}  // namespace infuse::importers
