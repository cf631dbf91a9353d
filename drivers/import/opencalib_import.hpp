#pragma once

#include <filesystem>

#include "drivers/measurement/error.hpp"

namespace infuse::importers {

/// Converts one scene of OpenCalib (SensorsCalibration, lidar to camera) to a drive: NAME.calib.txt
/// (K, D, T as 3 × 4: T_camera_lidar) and, in the same folder, NAME.pcd and NAME.png or NAME.jpg.
/// The files are hard-linked, or copied if linking fails; the published extrinsics are written to
/// drive.toml and truth/rig.toml. Stamps are synthetic. `drive` must not exist or be empty.
Result<void> import_opencalib(const std::filesystem::path& calibration,
                              const std::filesystem::path& drive);

}  // namespace infuse::importers
