#pragma once

#include "daemon/config/odometry_settings.hpp"
#include "daemon/health/odometry_health.hpp"
#include "daemon/pipeline/vehicle_sample.hpp"
#include "daemon/protocol/reports.hpp"
#include "fusion/motion/odometry_filter.hpp"

namespace infuse::daemon {

/// Dead reckoning on the fusion thread, in a frame of its own that begins where the drive does: x
/// ahead, no jumps. A receiver's course is not used, as it would turn that frame while driving.
class OdometryTracker {
 public:
  explicit OdometryTracker(const OdometrySettings& settings)
      : filter_(settings.filter),
        use_gnss_speed_(settings.use_gnss_speed),
        max_silence_(settings.filter.max_silence) {}

  void add(const VehicleSample& sample);

  /// Nothing more comes: works off what still waits.
  void finish() { filter_.flush(); }

  const geometry::Trajectory& trajectory() const { return filter_.trajectory(); }

  /// Where the vehicle was, in the frame of odometry.
  PoseReport pose_at(Stamp stamp) const;

  /// What is told of it at the drive time `now`.
  OdometryStatus status(Stamp now) const;

 private:
  const char* reason_at(Stamp now) const;

  motion::OdometryFilter filter_;
  bool use_gnss_speed_;
  Duration max_silence_;
};

}  // namespace infuse::daemon
