#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include "drivers/import/import_files.hpp"
#include "drivers/import/kitti_calibration.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/vehicle_samples.hpp"
#include "drivers/recording/trajectory_file.hpp"
#include "drivers/recording/turn.hpp"

namespace infuse::importers {

/// Content of a KITTI folder of any layout.
struct KittiRecording {
  KittiCalibration calibration;
  bool times_trusted = false;  ///< false: stamps are index · 0.1 s
  std::vector<StampedFile> sweeps;
  std::optional<recording::Turn> turn;  ///< of the sweeps, whose returns have no times otherwise
  bool deskewed = false;                ///< sweeps are deskewed to the middle of their turn
  std::array<std::vector<StampedFile>, 4> images;  ///< by KITTI's camera number
  std::array<Duration, 4> stamp_delay{};           ///< of the images, to the middle of the exposure
  std::array<Duration, 4> stamp_delay_sigma{};     ///< standard deviation of an exposure's time
  std::vector<recording::TrajectoryPose> poses;    ///< T_map_vehicle
  std::vector<WheelOdometry> speed;                ///< forward velocity
  std::vector<ImuSample> imu;
  std::vector<GnssFix> gnss;
  std::vector<Error> notes;  ///< skipped files, and the reason
};

/// Reads the object layout: velodyne/, image_N/, calib/NNNNNN.txt. If frames differ in calibration,
/// only those with the most frequent one are read.
Result<KittiRecording> read_kitti_object(const std::filesystem::path& folder);

/// Reads the odometry layout: velodyne/, image_N/, calib.txt (or the only calib*.txt), times.txt;
/// poses in poses.txt, poses_gt_cam0.txt or ../../poses/NAME.txt. Without times.txt, stamps are
/// synthetic. The sweeps are deskewed already. The map frame is the vehicle frame at the first
/// pose.
Result<KittiRecording> read_kitti_odometry(const std::filesystem::path& folder);

/// Reads the raw layout: velodyne_points/, image_0N/, oxts/, each with data/ and timestamps.txt;
/// calib_cam_to_cam.txt and the other calibration files in the folder or its parent. The map frame
/// is east-north-up at the first fix; poses, speed, imu and gnss are from the inertial navigation
/// system. The turn of the lidar is checked on the sweeps themselves (`check_turn`).
Result<KittiRecording> read_kitti_raw(const std::filesystem::path& folder);

}  // namespace infuse::importers
