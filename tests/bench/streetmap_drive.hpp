#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/rig.hpp"
#include "fusion/streetmap/local_grid.hpp"
#include "fusion/streetmap/segment_map.hpp"
#include "fusion/streetmap/street_plan.hpp"

/// Simulated drives on street maps, rendered once, and what of them the benchmarks use.
namespace infuse::streetmap::bench {

/// What one update sees, collected along the true way, and where the vehicle is.
struct View {
  double seconds = 0;  ///< since the start of the drive
  PlanarPose truth;
  GridSamples samples;
};

/// A picture and where the vehicle was.
struct PosedImage {
  PlanarPose truth;
  CameraFrame image;
};

/// A map made of the drive's OpenStreetMap file, and the bytes that it reads.
struct DriveMap {
  StreetPlan plan;
  std::vector<std::byte> bytes;
  SegmentMap map;
};

/// Renders `drive` unless it is there: "pedestrian_zone", "street", "kitti_00", "kitti_05" or
/// "kitti_07", the latter with the recordings of INFUSE_REAL_DATA. False, and why on standard
/// error, where that fails.
bool render(const std::string& drive);

/// The views of a drive, two a second, from its cache (written by the first call).
std::vector<View> read_views(const std::string& drive);

/// `count` pictures evenly over the drive, and the camera's mount.
std::vector<PosedImage> read_posed_images(const std::string& drive, int count, CameraMount& mount);

/// Makes the drive's map; of another plan where one is given.
DriveMap make_map(const std::string& drive, const std::optional<StreetPlan>& plan = {});

}  // namespace infuse::streetmap::bench
