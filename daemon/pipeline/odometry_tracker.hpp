#pragma once

#include "daemon/config/odometry_settings.hpp"
#include "daemon/health/odometry_health.hpp"
#include "daemon/pipeline/vehicle_sample.hpp"
#include "daemon/protocol/reports.hpp"
#include "fusion/motion/odometry_filter.hpp"

namespace infuse::daemon {

/// Dead reckoning on the fusion thread, in the frame `odom`: origin at the start of the drive, x
/// ahead, no jumps. The GNSS course is not used, as it would rotate that frame while driving.
class OdometryTracker {
 public:
  explicit OdometryTracker(const OdometrySettings& settings)
      : filter_(settings.filter),
        use_gnss_speed_(settings.use_gnss_speed),
        max_silence_(settings.filter.max_silence) {}

  /// Adds a sample; samples of different sensors may be out of order by the reordering time.
  void add(const VehicleSample& sample);

  /// Processes the samples that still wait for earlier ones.
  void finish() { filter_.flush(); }

  /// Poses of the vehicle in the frame `odom`.
  const geometry::Trajectory& trajectory() const { return filter_.trajectory(); }

  /// Returns the pose at `stamp` in the frame `odom`.
  PoseReport pose_at(Stamp stamp) const;

  /// Returns the status for HEALTH at the drive time `now`.
  OdometryStatus status(Stamp now) const;

 private:
  const char* reason_at(Stamp now) const;

  motion::OdometryFilter filter_;
  bool use_gnss_speed_;
  Duration max_silence_;
};

}  // namespace infuse::daemon
