#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"

namespace infuse::recording {

/// How a KITTI folder is laid out.
enum class KittiLayout {
  kRaw,  ///< …_sync with velodyne_points/, image_0N/data/, oxts/; calib_*.txt beside or above
  kOdometry,  ///< velodyne/, image_N/, times.txt, one calib*.txt; poses
  kObject,    ///< velodyne/, image_N/, calib/NNNNNN.txt: no times
};

/// What an import made.
struct KittiImportSummary {
  KittiLayout layout = KittiLayout::kObject;
  size_t sweeps = 0;
  size_t images = 0;  ///< of all cameras
  size_t poses = 0;
  bool times_trusted = false;
  std::vector<Error> notes;  ///< what was left out, and why
};

/// Which of the layouts a folder has; an error that says what was looked for.
Result<KittiLayout> detect_kitti_layout(const std::filesystem::path& folder);

/// Makes a drive of a KITTI folder: sweeps and images are hard-linked, or copied where that is not
/// possible; the published extrinsics go to drive.toml and truth/rig.toml, poses to
/// truth/poses.tum. `drive` must not exist, or be empty.
///
/// T_camera_lidar of camera i is [I | K⁻¹·p] · R0_rect · Tr_velo_to_cam with Pᵢ = [K | p]: the
/// fourth column of Pᵢ is the camera's own offset from camera 0.
Result<KittiImportSummary> import_kitti(const std::filesystem::path& folder,
                                        const std::filesystem::path& drive);

/// The layout's name: "raw", "odometry", "object".
const char* to_string(KittiLayout layout);

}  // namespace infuse::recording
