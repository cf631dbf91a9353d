#pragma once

#include <filesystem>

#include "drivers/measurement/error.hpp"

namespace infuse::recording {

/// Makes a drive of one scene of OpenCalib (SensorsCalibration, lidar to camera): NAME.calib.txt
/// (K, D, T as 3 × 4: T_camera_lidar) and beside it NAME.pcd and NAME.png or NAME.jpg. Sweep and
/// picture are hard-linked, or copied where that is not possible; the published extrinsics go to
/// drive.toml and truth/rig.toml. The scene's time is synthetic. `drive` must not exist, or be
/// empty.
Result<void> import_opencalib(const std::filesystem::path& calibration,
                              const std::filesystem::path& drive);

}  // namespace infuse::recording
