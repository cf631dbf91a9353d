#include "daemon/tools/map/lidar_replay.hpp"

#include "daemon/pipeline/odometry_plan.hpp"

namespace infuse::daemon {

LidarReplay::LidarReplay(const SensorSetup& setup, size_t lidar)
    : sweeps_(plan_odometry({.use_lidar = true}, setup, lidar),
              setup.rig.lidars[lidar].T_vehicle_lidar),
      has_motion_sensor_(setup.vehicle.has_motion_sensor()) {}

mapping::SweepMotion LidarReplay::motion_until(Stamp end) {
  const geometry::MotionBetween motion = sweeps_.trajectory().between(last_, end);
  last_ = end;
  mapping::SweepMotion out;
  out.stamp = end;
  out.registered = sweeps_.registered();
  out.measured = motion.usable() && (out.registered || has_motion_sensor_);
  if (motion.usable()) {
    out.T_from_to = motion.T_from_to;
    out.covariance = motion.covariance;
  }
  return out;
}

}  // namespace infuse::daemon
