#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/rig.hpp"
#include "fusion/geometry/trajectory.hpp"
#include "fusion/streetmap/local_grid.hpp"
#include "fusion/streetmap/segment_map.hpp"
#include "fusion/streetmap/street_plan.hpp"

/// Simulated drives on street maps, rendered once, for benchmarks.
namespace infuse::streetmap::bench {

/// Samples of one update, collected along the true trajectory, and the true pose.
struct View {
  double seconds = 0;  ///< since the start of the drive
  PlanarPose truth;
  GridSamples samples;
};

/// An image and the true pose of the vehicle.
struct PosedImage {
  PlanarPose truth;
  CameraFrame image;
};

/// A map made from the OpenStreetMap file of a drive, and its bytes.
struct DriveMap {
  StreetPlan plan;
  std::vector<std::byte> bytes;
  SegmentMap map;
};

/// Makes `drive`, rendered once: the name of a scenario, "bare_SEED" of its family, or "kitti_00",
/// "kitti_05", "kitti_07", the latter with the recordings of INFUSE_REAL_DATA. On failure prints
/// the reason to standard error and returns false.
bool render(const std::string& drive);

/// True if `drive` exists.
bool is_rendered(const std::string& drive);

/// Reads the views of a drive, two per second, from its cache (written by the first call).
std::vector<View> read_views(const std::string& drive);

/// True poses of a drive, map frame; empty if there is none.
geometry::Trajectory read_truth(const std::string& drive);

/// Reads `count` images, evenly spread over the drive, and the mount of the camera.
std::vector<PosedImage> read_posed_images(const std::string& drive, int count, CameraMount& mount);

/// Makes the map of a drive, or of another plan.
DriveMap make_map(const std::string& drive, const std::optional<StreetPlan>& plan = {});

}  // namespace infuse::streetmap::bench
