#pragma once

#include <optional>
#include <string>

#include "drivers/measurement/stamp.hpp"

namespace infuse::motion {

/// The vehicle and its sensors, as the odometry filter believes them. Noise of a sample is white;
/// `…_walk` is per √s.
struct OdometryOptions {
  bool planar = true;      ///< roll, pitch and height stay 0; false: full 3D, needs an `ImuSample`
  double wheelbase = 2.7;  ///< m
  double track = 1.55;     ///< m between left and right wheels
  double steering_ratio = 0;         ///< steering wheel to road wheel; 0: steering is not used
  double characteristic_speed = 24;  ///< m/s at which understeer halves the response to steering

  Duration wheel_delay{0};             ///< ns from measuring to stamp, subtracted
  Duration imu_delay{0};               ///< ns, the same
  Duration gnss_delay{0};              ///< ns, the same; must be less than `reorder`
  Duration reorder{20'000'000};        ///< ns that a sample waits for earlier ones
  Duration max_silence{500'000'000};   ///< ns without speed, or without rotation, before the filter
                                       ///< is not trusted
  Duration pose_interval{10'000'000};  ///< ns between poses of the trajectory, at least
  Duration standstill_after{400'000'000};  ///< ns of wheels at rest before the vehicle is

  double wheel_noise = 0.06;        ///< m/s
  double yaw_rate_noise = 0.005;    ///< rad/s, of the vehicle's yaw-rate sensor
  double gyro_noise = 0.004;        ///< rad/s, of the inertial unit
  double acceleration_noise = 1.0;  ///< m/s², mounting and road included
  double steering_noise = 0.01;     ///< rad/s of yaw rate, ten times a second
  double straight_steering_noise =
      0.15;  ///< rad: how far the steering is from straight, ten times a second;
  ///< far more than its spread, since it stays there for long
  double gnss_speed_noise = 0.4;     ///< m/s, ten times a second; its errors last longer
  double gnss_course_noise = 0.015;  ///< rad at 10 m/s and above; grows below
  double standstill_speed = 0.05;    ///< m/s below which a wheel is at rest

  double acceleration_walk = 2.0;      ///< m/s² per √s: how the acceleration walks
  double angular_velocity_walk = 0.4;  ///< rad/s per √s: how the angular velocity walks
  double translation_walk = 0.03;  ///< m per √s: translation that wheels do not see, while moving
  double rotation_walk = 2e-4;     ///< rad per √s: rotation that gyros do not see, while moving

  double yaw_bias_sigma = 0.01;       ///< rad/s at the start
  double gyro_bias_sigma = 0.01;      ///< rad/s at the start
  double bias_walk = 3e-5;            ///< rad/s per √s
  double wheel_scale = 1;             ///< true over measured speed, at the start
  double wheel_scale_sigma = 0.01;    ///< at the start
  double wheel_scale_walk = 1e-5;     ///< per √s
  double steering_zero_sigma = 0.01;  ///< rad at the steering wheel, road camber included
  Duration steering_zero_time_constant{20'000'000'000};  ///< ns after which it may be another

  /// What is wrong with the options, or nothing.
  std::optional<std::string> invalid() const;
};

}  // namespace infuse::motion
