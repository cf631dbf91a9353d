#pragma once

#include <cmath>

#include "drivers/measurement/vehicle_samples.hpp"
#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/motion/odometry_options.hpp"

namespace infuse::motion {

/// A quantity the filter has learned.
struct EstimatedParameter {
  double value = 0;
  double sigma = 0;  ///< standard deviation
};

/// The extended Kalman filter of the vehicle's motion: pose, speed and acceleration along x,
/// angular velocity, and what the sensors' errors are. The vehicle moves along its x axis (no side
/// slip at the rear axle) and turns; the pose's error is a left perturbation in the map frame, so
/// that it is carried through time unchanged and only grows.
///
/// What is learned of a bias while driving mends the way that lies behind, little by little. What
/// is learned while standing would do so at once, by metres: then samples correct no more than the
/// last tenths of a second, so that a vehicle that stands is not moved. That gain is not the best
/// one for the pose; the covariance is that of the pose as it is.
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

  /// Sets the pose and forgets the motion; what has been learned stays.
  void set_pose(const Eigen::Isometry3d& T_odom_vehicle, const geometry::Matrix6& covariance);

  /// Moves on by a time.
  void predict(double seconds);

  /// Speeds of the wheels; how many of them agreed with the motion.
  int update_wheels(const WheelOdometry& sample);
  /// False where the sample disagrees with the motion, or says nothing.
  bool update_yaw_rate(double yaw_rate);
  bool update_gyro(const ImuSample& sample);
  bool update_gravity(const ImuSample& sample);
  bool update_steering(double steering_angle);
  bool update_gnss(const GnssFix& fix);
  /// The vehicle stands.
  void update_standstill();

  /// A time passed without samples: the pose stays and gets vague, the motion is not known.
  void reset_motion(double seconds);

  /// Forgets how sure speed or rotation were, after they were contradicted for long.
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
  Vector x_ = Vector::Zero();  // the pose's part is always 0
  Matrix P_ = Matrix::Zero();
  // Covariance of what of the pose's error is recent, a fading memory, with the whole state's.
  RecentMatrix recent_ = RecentMatrix::Zero();
};

}  // namespace infuse::motion
