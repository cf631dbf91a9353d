#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "daemon/config/streetmap_settings.hpp"
#include "daemon/health/streetmap_health.hpp"
#include "daemon/pipeline/image_match.hpp"
#include "daemon/pipeline/street_map_fixes.hpp"
#include "daemon/pipeline/street_map_motion.hpp"
#include "daemon/pipeline/view_tap.hpp"
#include "daemon/protocol/reports.hpp"
#include "daemon/streetmap/street_map_file.hpp"
#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/rig.hpp"
#include "drivers/measurement/vehicle_samples.hpp"
#include "fusion/geometry/camera_model.hpp"
#include "fusion/geometry/trajectory.hpp"
#include "fusion/motion/deskew.hpp"
#include "fusion/streetmap/tracker.hpp"

namespace infuse::daemon {

/// Tracking of the vehicle on the street map, on the fusion thread: particles move with odometry at
/// every sweep, sweeps and images fill the local grid, and `update_hz` times a second of drive time
/// the particles are weighted. Initialised by the configured pose, else by several GNSS fixes with
/// a course, or by the drive itself once it fits one place only. GNSS fixes witness the pose
/// throughout.
class StreetMapTracker {
 public:
  /// `settings.invalid()` must be empty.
  StreetMapTracker(const StreetMapSettings& settings, StreetMapFile map, const Rig& rig);

  /// Begins where the vehicle is on another map, which this takes the place of: at that pose where
  /// both maps have latitude and longitude or are of one frame and it is not LOST, else without
  /// one. Requires `!started()`: settings without a pose.
  void go_on_from(const StreetMapTracker& before);

  /// Adds a fix. It is used at the next sweep; of a map without latitude and longitude, never.
  void add_gnss(const GnssFix& fix);

  /// Moves the particles to the time of the snapshot, adds its returns and, when due, weights the
  /// particles. `predicted`: where the odometry has the vehicle now, measured or not. Returns the
  /// pose on the map as of the snapshot; stamp, speed and yaw rate are those of `odometry`.
  PoseReport process(const SweepSnapshot& snapshot, const geometry::Trajectory& trajectory,
                     const geometry::PoseAt& predicted, const PoseReport& odometry);

  /// Adds an image and the sweep as of its exposure. Ignored where the trajectory does not connect
  /// the exposure with the time of the last snapshot.
  void add_image(const ImageMatch& match, const geometry::Trajectory& trajectory);

  /// Returns the pose on the map as of the last snapshot; the rest is that of `odometry`.
  PoseReport pose(const PoseReport& odometry) const;

  /// True once it has a place on the map, which may be wrong.
  bool started() const { return tracker_->started(); }

  /// Writes where the vehicle is on the map, for somebody who looks.
  void write(ViewMapPose& out) const;

  /// Returns the status for HEALTH.
  StreetMapStatus status() const;

 private:
  void use_fixes(const geometry::Trajectory& trajectory);
  void update_if_due();
  streetmap::DeskewedView view(const SweepSnapshot& snapshot) const;

  StreetMapSettings settings_;
  Rig rig_;
  StreetMapFile map_;
  std::vector<geometry::CameraModel> cameras_;
  std::optional<StreetMapFixes> fixes_;          // nothing: the map has no latitude and longitude
  std::unique_ptr<streetmap::Tracker> tracker_;  // reads map_
  streetmap::ImageFeatures features_;
  StreetMapMotion motion_;  // of the particles
  Stamp next_update_ = Stamp::earliest();
  uint64_t updates_ = 0;
};

}  // namespace infuse::daemon
