#pragma once

#include <cmath>

#include "drivers/measurement/vehicle_samples.hpp"
#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/motion/odometry_options.hpp"

namespace infuse::motion {

/// Estimated parameter of a sensor.
struct EstimatedParameter {
  double value = 0;
  double sigma = 0;  ///< standard deviation
};

/// Extended Kalman filter of the vehicle motion: pose, speed and acceleration along x, angular
/// velocity, and sensor errors. The vehicle moves along its x axis (no side slip at the rear axle)
/// and turns. The pose error is a left perturbation in the odometry frame, so that prediction
/// leaves it unchanged and only adds to it.
///
/// A bias learned while driving corrects the path driven before, gradually. A bias learned at
/// standstill would correct it at once, by metres: then samples correct only the last tenths of a
/// second, so that a standing vehicle does not move. That gain is not optimal for the pose; the
/// covariance is that of the actual pose.
class OdometryState {
 public:
  /// Indices of the error state.
  enum Index : int {
    kPose = 0,
    kSpeed = 6,
    kAcceleration = 7,
    kAngularVelocity = 8,
    kYawRateBias = 11,
    kGyroBias = 12,
    kWheelScale = 15,
    kSteeringZero = 16,
    kSize = 17,
  };
  using Vector = Eigen::Matrix<double, kSize, 1>;
  using Matrix = Eigen::Matrix<double, kSize, kSize>;
  using RecentMatrix = Eigen::Matrix<double, 6, kSize>;

  /// `options.invalid()` must be empty.
  explicit OdometryState(const OdometryOptions& options);

  /// Sets the pose and resets the motion; the learned parameters stay.
  void set_pose(const Eigen::Isometry3d& T_odom_vehicle, const geometry::Matrix6& covariance);

  /// Predicts the state after a time step.
  void predict(double seconds);

  /// Updates with the wheel speeds; returns how many were consistent with the motion.
  int update_wheels(const WheelOdometry& sample);
  /// Updates with one sample. Returns false if the sample is inconsistent with the motion or
  /// carries no information.
  bool update_yaw_rate(double yaw_rate);
  bool update_gyro(const ImuSample& sample);
  bool update_gravity(const ImuSample& sample);
  bool update_steering(double steering_angle);
  bool update_gnss(const GnssFix& fix);
  /// Updates with zero speed and rotation.
  void update_standstill();

  /// Resets the motion after a time without samples: the pose stays with a larger covariance, the
  /// motion is unknown.
  void reset_motion(double seconds);

  /// Resets the covariance of speed or rotation after prolonged contradiction.
  void reset_speed_covariance();
  void reset_rotation_covariance();

  const Eigen::Isometry3d& T_odom_vehicle() const { return T_odom_vehicle_; }
  geometry::Matrix6 pose_covariance() const { return P_.topLeftCorner<6, 6>(); }
  double speed() const { return x_[kWheelScale] * x_[kSpeed]; }
  Eigen::Vector3d angular_velocity() const { return x_.segment<3>(kAngularVelocity); }
  EstimatedParameter parameter(int index) const;

 private:
  bool is_moving() const { return std::abs(x_[kSpeed]) > options_.standstill_speed; }
  bool update(double innovation, const Vector& derivative, double noise, double gate);

  OdometryOptions options_;
  Eigen::Isometry3d T_odom_vehicle_ = Eigen::Isometry3d::Identity();
  Vector x_ = Vector::Zero();  // the pose block is always 0
  Matrix P_ = Matrix::Zero();
  // Covariance of the recent part of the pose error (fading memory) with the whole state.
  RecentMatrix recent_ = RecentMatrix::Zero();
};

}  // namespace infuse::motion
