#include "daemon/tools/map/lidar_replay.hpp"

namespace infuse::daemon {
namespace {

OdometrySettings lidar_replay_settings(const SensorSetup& setup, size_t lidar) {
  OdometrySettings settings;
  // As in the pipeline: sensors that measure in the vehicle's axes know what is forward.
  settings.filter.moves_forward =
      setup.vehicle.has_motion_sensor() || setup.rig.lidars[lidar].is_mounting_known();
  return settings;
}

}  // namespace

LidarReplay::LidarReplay(const SensorSetup& setup, size_t lidar)
    : odometry_(lidar_replay_settings(setup, lidar), true, setup.rig.lidars[lidar].T_vehicle_lidar),
      lidar_motion_(setup.rig.lidars[lidar].T_vehicle_lidar),
      deskewer_(setup.rig.lidars[lidar].T_vehicle_lidar),
      has_motion_sensor_(setup.vehicle.has_motion_sensor()),
      max_wait_(has_motion_sensor_ ? OdometrySettings().max_wait : Duration::zero()) {}

void LidarReplay::add_sweep(const Sweep& sweep) {
  odometry_.mark(end_of(sweep), true);
  waiting_.push_back(sweep);
}

bool LidarReplay::is_due(const Sweep& sweep, Stamp now) const {
  const Stamp end = end_of(sweep);
  return now - end >= max_wait_ ||
         *odometry_.trajectory().uncovered_reason(sweep.stamp, end) == '\0';
}

mapping::SweepMotion LidarReplay::process(const Sweep& sweep) {
  const Stamp end = end_of(sweep);
  odometry_.process_until(end);
  const auto deskew = [&] { deskewer_.deskew(sweep, odometry_.trajectory(), end, deskewed_); };
  deskew();
  const bool registered = lidar_motion_.measure(sweep, odometry_, deskewer_, deskewed_, deskew);
  const geometry::MotionBetween motion = odometry_.trajectory().between(last_, end);
  last_ = end;
  mapping::SweepMotion out;
  out.stamp = end;
  out.registered = registered;
  out.measured = motion.usable() && (registered || has_motion_sensor_);
  if (motion.usable()) {
    out.T_from_to = motion.T_from_to;
    out.covariance = motion.covariance;
  }
  return out;
}

}  // namespace infuse::daemon
