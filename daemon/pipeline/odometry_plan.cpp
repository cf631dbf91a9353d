#include "daemon/pipeline/odometry_plan.hpp"

namespace infuse::daemon {

OdometrySettings plan_odometry(OdometrySettings settings, const SensorSetup& setup, size_t lidar) {
  const VehicleSetup& vehicle = setup.vehicle;
  const bool has_lidar = lidar < setup.rig.lidars.size();
  const bool is_mounted = has_lidar && setup.rig.lidars[lidar].is_mounting_known();
  const bool has_motion_sensor = vehicle.has_motion_sensor();
  settings.use_lidar = has_lidar && settings.use_lidar.value_or(is_mounted || !has_motion_sensor);
  settings.planar = settings.planar.value_or(!*settings.use_lidar && !vehicle.has_gyros());
  settings.filter.moves_forward = has_motion_sensor || !has_lidar || is_mounted;
  if (vehicle.imu_delay_sigma > 0) settings.filter.imu_delay_sigma = vehicle.imu_delay_sigma;
  if (!has_motion_sensor) settings.max_wait = Duration::zero();
  return settings;
}

}  // namespace infuse::daemon
