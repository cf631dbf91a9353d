#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"

namespace infuse::importers {

/// Layout of a KITTI folder.
enum class KittiLayout {
  kRaw,  ///< …_sync with velodyne_points/, image_0N/data/, oxts/; calib_*.txt in the folder or its
         ///< parent
  kOdometry,  ///< velodyne/, image_N/, times.txt, one calib*.txt; poses
  kObject,    ///< velodyne/, image_N/, calib/NNNNNN.txt; no stamps
};

/// Result of an import.
struct KittiImportSummary {
  KittiLayout layout = KittiLayout::kObject;
  size_t sweeps = 0;
  size_t images = 0;  ///< number of images of all cameras
  size_t poses = 0;
  bool times_trusted = false;
  std::vector<Error> notes;  ///< skipped files, and the reason
};

/// Detects the layout of a folder. The error states what each layout contains.
Result<KittiLayout> detect_kitti_layout(const std::filesystem::path& folder);

/// Converts a KITTI folder to a drive. Sweeps and images are hard-linked, or copied if linking
/// fails; the published extrinsics are written to drive.toml and truth/rig.toml, poses to
/// truth/poses.tum. `drive` must not exist or be empty.
///
/// T_camera_lidar of camera i is [I | K⁻¹·p] · R0_rect · Tr_velo_to_cam with Pᵢ = [K | p]: the
/// fourth column of Pᵢ contains the offset of camera i from camera 0.
Result<KittiImportSummary> import_kitti(const std::filesystem::path& folder,
                                        const std::filesystem::path& drive);

/// Name of a layout: "raw", "odometry", "object".
const char* name_of(KittiLayout layout);

}  // namespace infuse::importers
