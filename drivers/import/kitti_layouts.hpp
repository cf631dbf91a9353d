#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <vector>

#include "drivers/import/import_files.hpp"
#include "drivers/import/kitti_calibration.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/vehicle_samples.hpp"
#include "drivers/recording/trajectory_file.hpp"

namespace infuse::recording {

/// What a KITTI folder holds, whatever its layout.
struct KittiRecording {
  KittiCalibration calibration;
  bool times_trusted = false;  ///< false: stamps are index · 0.1 s
  std::vector<StampedFile> sweeps;
  std::array<std::vector<StampedFile>, 4> images;  ///< by KITTI's number of the camera
  std::vector<TrajectoryPose> poses;               ///< T_map_vehicle
  std::vector<ImuSample> imu;
  std::vector<GnssFix> gnss;
  std::vector<Error> notes;  ///< what was left out, and why
};

/// velodyne/, image_N/, calib/NNNNNN.txt. Where frames differ in calibration, those that share the
/// most frequent one are taken.
Result<KittiRecording> read_kitti_object(const std::filesystem::path& folder);

/// velodyne/, image_N/, calib.txt (or the one calib*.txt), times.txt; poses in poses.txt,
/// poses_gt_cam0.txt or ../../poses/NAME.txt. Without times.txt times are synthetic. The map frame
/// is the vehicle's own at the first pose.
Result<KittiRecording> read_kitti_odometry(const std::filesystem::path& folder);

/// velodyne_points/, image_0N/, oxts/, each with data/ and timestamps.txt; calib_cam_to_cam.txt and
/// the others in the folder or the one above. The map frame is east-north-up at the first fix;
/// poses, imu and gps are those of the inertial navigation system.
Result<KittiRecording> read_kitti_raw(const std::filesystem::path& folder);

}  // namespace infuse::recording
