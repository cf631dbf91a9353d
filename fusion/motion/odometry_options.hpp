#pragma once

#include <optional>
#include <string>

#include "drivers/measurement/stamp.hpp"

namespace infuse::motion {

/// Vehicle and sensor parameters of the odometry filter. Sample noise is white; `…_walk` is a
/// random walk per √s.
struct OdometryOptions {
  bool planar = true;  ///< roll, pitch and height stay 0; false: full 3D, for a vehicle with three
                       ///< gyros or a `RelativePose`
  bool moves_forward = true;  ///< the vehicle moves along its x axis; false: in any direction, as
                              ///< the frame of a lidar whose mounting is not known
  double wheelbase = 2.7;     ///< m
  double track = 1.55;        ///< m between left and right wheels
  double steering_ratio = 0;  ///< steering wheel angle to road wheel angle; 0: unknown, it is
                              ///< estimated
  double characteristic_speed = 24;  ///< m/s at which understeer halves the steering response

  Duration wheel_delay{0};            ///< ns from measurement to stamp, subtracted
  Duration imu_delay{0};              ///< ns, the same
  Duration gnss_delay{0};             ///< ns, the same; must be less than `reorder`
  Duration reorder{20'000'000};       ///< ns that a sample waits for earlier ones
  Duration max_silence{500'000'000};  ///< maximum ns without speed or without rotation; then the
                                      ///< filter is unusable
  Duration max_gnss_silence{2'500'000'000};  ///< ns, the same for what a GNSS receiver measures
  Duration lidar_drift_time_constant{5'000'000'000};  ///< ns, of the errors that results share
  Duration pose_interval{10'000'000};      ///< minimum ns between poses of the trajectory
  Duration standstill_after{400'000'000};  ///< ns of wheels at rest, then the vehicle stands

  double wheel_noise = 0.06;              ///< m/s
  double yaw_rate_noise = 0.005;          ///< rad/s, of the vehicle's yaw-rate sensor
  double gyro_noise = 0.004;              ///< rad/s, of the inertial unit
  double acceleration_noise = 3.0;        ///< m/s², at 100 Hz; errors of mounting and road last
  double steering_noise = 0.01;           ///< rad/s of yaw rate, at 10 Hz
  double straight_steering_noise = 0.15;  ///< rad: steering angle on straight roads, at 10 Hz; far
                                          ///< above its spread, since the errors are correlated
  double gnss_speed_noise = 0.4;          ///< m/s, at 10 Hz; the errors are correlated
  double gnss_course_noise = 0.015;       ///< rad at 10 m/s and above; larger below
  double east_heading_sigma = 0;          ///< rad, of the heading of the odometry frame's x axis;
                                          ///< 0: it points east. 10: unknown
  double frame_tilt_sigma = 0.1;          ///< rad, of the odometry frame, which a slope tilts
  double lidar_rotation_noise = 2e-4;     ///< rad, added to what a `RelativePose` states
  double lidar_translation_noise = 2e-3;  ///< m, the same
  double lidar_rotation_drift = 2e-5;     ///< rad/m, errors that successive results share
  double lidar_translation_drift = 2e-3;  ///< m/m, the same
  double standstill_speed = 0.05;         ///< m/s; a slower wheel is at rest

  double acceleration_walk = 2.0;  ///< m/s² per √s, random walk of the acceleration
  double velocity_walk = 1.0;      ///< m/s per √s, of the velocity across and up, which is not 0
                                   ///< without `moves_forward`
  double angular_velocity_walk = 0.4;  ///< rad/s per √s, random walk of the angular velocity
  double tilt_rate_walk = 0.1;         ///< rad/s per √s, of roll and pitch rate, which decay
  double translation_walk = 0.03;  ///< m per √s, translation not seen by the wheels, while moving
  double rotation_walk = 2e-4;     ///< rad per √s, rotation not seen by the gyros, while moving

  double yaw_bias_sigma = 0.01;        ///< rad/s, initial
  double gyro_bias_sigma = 0.01;       ///< rad/s, initial
  double bias_walk = 3e-5;             ///< rad/s per √s
  double wheel_scale = 1;              ///< true over measured speed, initial
  double wheel_scale_sigma = 0.01;     ///< initial
  double wheel_scale_walk = 1e-5;      ///< per √s
  double steering_zero_sigma = 0.01;   ///< rad at the steering wheel, including road camber
  double yaw_rate_delay_sigma = 0.05;  ///< s, until a lidar or a course shows what remains
  double imu_delay_sigma = 0.05;       ///< s, the same
  double gnss_delay_sigma = 0.1;       ///< s, the same; receivers state speeds 0.1 to 0.4 s late
  double delay_walk = 0.002;           ///< s per √s, of the GNSS receiver
  double side_slip_sigma = 0.005;      ///< rad per m/s² across: a car at its rear axle
  double gnss_lever_sigma = 1.5;       ///< m along the vehicle: a receiver may be anywhere on it
  Duration steering_zero_time_constant{20'000'000'000};  ///< ns, time constant of its change

  /// Returns what is wrong with the options, or nothing.
  std::optional<std::string> invalid() const;
};

}  // namespace infuse::motion
