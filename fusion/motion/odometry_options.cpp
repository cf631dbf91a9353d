#include "fusion/motion/odometry_options.hpp"

namespace infuse::motion {

std::optional<std::string> OdometryOptions::invalid() const {
  if (!(wheelbase > 0 && wheelbase < 30) || !(track > 0 && track < 10)) {
    return "wheelbase and track must be positive, and less than 30 and 10 m";
  }
  if (!(steering_ratio >= 0 && steering_ratio < 1000))
    return "steering_ratio must be between 0 and 1000";
  if (!(characteristic_speed > 0)) return "characteristic_speed must be positive";
  if (!(wheel_scale > 0.5 && wheel_scale < 2)) return "wheel_scale must be near 1";
  if (reorder < Duration::zero() || pose_interval < Duration::zero()) {
    return "reorder and pose_interval must not be negative";
  }
  for (const Duration time : {max_silence, max_gnss_silence, standstill_after,
                              steering_zero_time_constant, lidar_drift_time_constant}) {
    if (time <= Duration::zero()) {
      return "max_silence, standstill_after and the time constants must be positive";
    }
  }
  for (const double noise :
       {wheel_noise, yaw_rate_noise, gyro_noise, acceleration_noise, steering_noise,
        straight_steering_noise, gnss_speed_noise, gnss_course_noise, lidar_rotation_noise,
        lidar_translation_noise, standstill_speed}) {
    if (!(noise > 0)) return "the noise of a sensor must be positive";
  }
  for (const double sigma :
       {acceleration_walk,    angular_velocity_walk, tilt_rate_walk,          translation_walk,
        rotation_walk,        yaw_bias_sigma,        gyro_bias_sigma,         bias_walk,
        wheel_scale_sigma,    wheel_scale_walk,      steering_zero_sigma,     east_heading_sigma,
        frame_tilt_sigma,     lidar_rotation_drift,  lidar_translation_drift, velocity_walk,
        yaw_rate_delay_sigma, imu_delay_sigma,       gnss_delay_sigma,        delay_walk,
        side_slip_sigma,      gnss_lever_sigma}) {
    if (!(sigma >= 0)) return "a standard deviation must not be negative";
  }
  return std::nullopt;
}

}  // namespace infuse::motion
