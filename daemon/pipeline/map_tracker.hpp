#pragma once

#include <optional>
#include <vector>

#include "daemon/config/streetmap_settings.hpp"
#include "daemon/health/streetmap_health.hpp"
#include "daemon/protocol/reports.hpp"
#include "drivers/gnss/local_frame.hpp"
#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/rig.hpp"
#include "drivers/measurement/vehicle_samples.hpp"
#include "fusion/geometry/camera_model.hpp"
#include "fusion/geometry/trajectory.hpp"
#include "fusion/motion/deskew.hpp"
#include "fusion/streetmap/tracker.hpp"

namespace infuse::daemon {

/// The vehicle on the street map, on the fusion thread: particles move with odometry at every
/// sweep, sweeps and pictures fill the local grid, and some times a second of drive time the
/// particles are weighed. It begins where the configuration says, else at the first fix of a
/// satellite receiver that also tells the course.
class MapTracker {
 public:
  /// `settings.invalid()` must be empty. The map outlives this.
  MapTracker(const StreetMapSettings& settings, const streetmap::SegmentMap& map, const Rig& rig);

  /// A receiver's fix, where nothing else said where the vehicle begins.
  void add_gnss(const GnssFix& fix);

  /// A sweep, straight as of its end. Moves the particles to that moment first.
  void add_sweep(const Sweep& sweep, const motion::DeskewedSweep& deskewed, size_t lidar,
                 const geometry::Trajectory& trajectory);

  /// A picture, and the sweep straight as of its exposure; after that sweep's `take_sweep`.
  void add_image(const CameraFrame& frame, Stamp exposure, size_t camera, size_t lidar,
                 const Sweep& sweep, const motion::DeskewedSweep& deskewed,
                 const geometry::Trajectory& trajectory);

  /// Where the vehicle is on the map, as of the last sweep's end; speed and yaw rate are those of
  /// `odometry`.
  PoseReport pose(const PoseReport& odometry) const;

  /// What is told of it once a second.
  StreetMapStatus status() const;

 private:
  void predict_to(Stamp stamp, const geometry::Trajectory& trajectory);
  void initialise();

  StreetMapSettings settings_;
  Rig rig_;
  std::vector<geometry::CameraModel> cameras_;
  std::optional<gnss::LocalFrame> frame_;  // nothing: the map has no latitude and longitude
  streetmap::Tracker tracker_;
  streetmap::ImageFeatures features_;
  bool initialised_ = false;
  Stamp now_ = Stamp::earliest();
  Stamp next_update_ = Stamp::earliest();
  uint64_t updates_ = 0;
};

}  // namespace infuse::daemon
