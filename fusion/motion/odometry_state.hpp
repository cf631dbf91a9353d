#pragma once

#include <array>
#include <cmath>

#include "drivers/measurement/vehicle_samples.hpp"
#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/motion/odometry_options.hpp"
#include "fusion/motion/relative_pose.hpp"

namespace infuse::motion {

/// Estimated parameter of a sensor.
struct EstimatedParameter {
  double value = 0;
  double sigma = 0;  ///< standard deviation
};

/// What became of a `RelativePose`.
struct RelativePoseUpdate {
  bool known = false;                                           ///< both times have a cloned pose
  bool informative = false;                                     ///< it measures any direction
  bool accepted = false;                                        ///< consistent with the motion
  bool speed_measured = false;                                  ///< to 1 m/s, whatever was known
  double speed_sigma = 0;                                       ///< m/s, of that
  bool rotation_measured = false;                               ///< about z, to 0.1 rad/s
  geometry::Vector6 error = geometry::Vector6::Zero();          ///< measured minus predicted motion
  geometry::Vector6 change_at_to = geometry::Vector6::Zero();   ///< left perturbation of the pose
  geometry::Vector6 change_at_now = geometry::Vector6::Zero();  ///< the same of the current pose
  /// Covariance of the corrected motion, left perturbation in the odometry frame.
  geometry::Matrix6 motion_covariance = geometry::Matrix6::Zero();
};

/// Extended Kalman filter of the vehicle motion: pose, speed and acceleration along x, angular
/// velocity, and sensor errors. The vehicle moves along its x axis (no side slip at the rear axle)
/// and turns; without `moves_forward` it has a velocity across and up too. The pose error is a left
/// perturbation in the odometry frame, so that prediction leaves it unchanged and only adds to it.
///
/// A bias learned while driving corrects the path driven before, gradually. A bias learned at
/// standstill would correct it at once, by metres: then samples correct only the last tenths of a
/// second, so that a standing vehicle does not move. That gain is not optimal for the pose; the
/// covariance is that of the actual pose.
///
/// Clones of past poses are part of the state (stochastic cloning, Roumeliotis and Burdick 2002),
/// so that a `RelativePose` that arrives later corrects the motion between them, and by correlation
/// speed, biases and wheel scale. It corrects only the motion since its `from`: the path before
/// stays, and the trajectory is continuous. `cloned_poses.cpp` holds this part,
/// `sample_updates.cpp` the updates with one sample.
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
    kEastHeading = 17,       ///< heading of the odometry frame, counter-clockwise from east
    kLidarDrift = 18,        ///< rad/m and m/m: error that successive relative poses share
    kLateralVelocity = 24,   ///< m/s along y; 0 with `moves_forward`
    kVerticalVelocity = 25,  ///< m/s along z, the same
    kFrameTilt = 26,         ///< rad about x and y: the odometry frame, relative to a level one
    kSteeringGain = 28,      ///< road wheel angle over steering wheel angle
    kGnssDelay = 29,         ///< s from measurement to stamp, of the GNSS receiver
    kSideSlip = 30,          ///< rad of the course per m/s² across: course minus heading
    kGnssLever = 31,         ///< m ahead of the rear axle, of the GNSS receiver
    kYawRateDelay = 32,      ///< s from measurement to stamp, of the yaw rate
    kGyroDelay = 33,         ///< s, the same of the gyros
    kMotionSize = 34,
    kSize = 52,  ///< with the clones
  };
  static constexpr size_t kMaxClones = (kSize - kMotionSize) / 6;
  using Vector = Eigen::Matrix<double, kSize, 1>;
  using Matrix = Eigen::Matrix<double, kSize, kSize>;
  using RecentMatrix = Eigen::Matrix<double, 6, kMotionSize>;
  using MotionMatrix = Eigen::Matrix<double, kMotionSize, kMotionSize>;

  /// `options.invalid()` must be empty.
  explicit OdometryState(const OdometryOptions& options);

  /// Sets the pose in a level frame and resets the motion; the learned parameters stay.
  void set_pose(const Eigen::Isometry3d& T_odom_vehicle, const geometry::Matrix6& covariance);

  /// Predicts the state after a time step.
  void predict(double seconds);

  /// Updates with the wheel speeds; returns how many were consistent with the motion.
  int update_wheels(const WheelOdometry& sample);
  /// Updates with one sample. Returns false if the sample is inconsistent with the motion or
  /// carries no information.
  bool update_yaw_rate(double yaw_rate, double change);  ///< rad/s; `change` of the rate: rad/s²
  bool update_gyro(const Eigen::Vector3d& rate, double noise, double change);  ///< of yaw, likewise
  bool update_gravity(const ImuSample& sample);
  bool update_steering(double steering_angle);
  bool update_gnss_speed(double speed, double noise);           ///< noise: m/s
  bool update_gnss_course(double course, double course_noise);  ///< noise: rad at 10 m/s
  /// Limits the yaw rate by the minimum turning radius (5 m).
  bool update_slow_turn();
  /// Updates with zero speed and rotation.
  void update_standstill();

  /// Speed of the vehicle that a sample states, relative to `speed()`, m/s. Of wheels that of the
  /// nearest: the others may spin.
  EstimatedParameter speed_error(const WheelOdometry& sample) const;
  EstimatedParameter gnss_speed_error(double measured, double noise) const;  ///< noise: m/s

  /// Sets what is known of a parameter by other means than this filter.
  void set_parameter(int index, const EstimatedParameter& known);

  /// Keeps a clone of the current pose, of time `stamp`; replaces the oldest.
  void clone_pose(Stamp stamp);
  /// Pose of a clone; null if there is none of that time.
  const Eigen::Isometry3d* cloned_pose(Stamp stamp) const;
  /// Covariance of a clone, which must exist.
  geometry::Matrix6 cloned_covariance(Stamp stamp) const;
  /// Updates with a motion between two clones; `gated`: one that is inconsistent with the motion is
  /// rejected.
  RelativePoseUpdate update_relative_pose(const RelativePose& pose, bool gated);
  /// Make speed or rotation since the time of a clone uncertain: a source was wrong.
  void release_speed(Stamp since, Stamp now);
  void release_rotation(Stamp since, Stamp now);

  /// Makes the speed's change in the last `seconds` uncertain: a source of speed went wrong since.
  void release_acceleration(double seconds);

  /// Makes the heading of the odometry frame and the biases about z uncertain after prolonged
  /// contradiction of courses. The path stays: nothing says when it turned wrongly.
  void release_heading();

  /// Resets the motion after a time without samples: the pose stays with a larger covariance, the
  /// motion is unknown.
  void reset_motion(double seconds);

  /// Resets the covariance of speed or rotation after prolonged contradiction.
  void reset_speed_covariance();
  void reset_rotation_covariance();

  const Eigen::Isometry3d& T_odom_vehicle() const { return T_odom_vehicle_; }
  geometry::Matrix6 pose_covariance() const { return P_.topLeftCorner<6, 6>(); }
  double speed_sigma() const;
  double yaw_rate_sigma() const {
    return std::sqrt(P_(kAngularVelocity + 2, kAngularVelocity + 2));
  }
  /// Speed along x, m/s; without `moves_forward` that in the direction of motion.
  double speed() const {
    return options_.moves_forward ? x_[kWheelScale] * x_[kSpeed] : velocity().norm();
  }
  Eigen::Vector3d angular_velocity() const { return x_.segment<3>(kAngularVelocity); }
  EstimatedParameter parameter(int index) const;

 private:
  void start_rotation();
  void release(int rate, double sigma, const geometry::Vector6& twist, Stamp since, Stamp now);
  bool is_moving() const { return velocity().norm() > options_.standstill_speed * x_[kWheelScale]; }
  /// m/s, in the vehicle frame.
  Eigen::Vector3d velocity() const {
    return {x_[kWheelScale] * x_[kSpeed], x_[kLateralVelocity], x_[kVerticalVelocity]};
  }
  /// 1: forward, −1: reverse.
  double driving_direction() const;
  /// Derivative of `speed()`'s magnitude; along x where the vehicle stands.
  Vector speed_derivative() const;
  /// `of_rate`: says nothing of the delays of rates, on which it depends.
  bool update(double innovation, const Vector& derivative, double noise, double gate,
              bool of_rate = false);
  bool update_late_rate(double rate, double noise, double change, int bias, int delay);
  /// Makes a gain one that leaves the vehicle where it is, but for its recent motion.
  void keep_position(const geometry::Vector6& recent_gain, Vector& gain) const;
  double expected_wheel_speed(size_t wheel) const;
  void apply(const Vector& change);
  void clear_clones();
  size_t find_clone(Stamp stamp) const;

  struct Clone {
    Stamp stamp = Stamp::earliest();  // earliest: unused
    Eigen::Isometry3d T_odom_vehicle = Eigen::Isometry3d::Identity();
  };

  OdometryOptions options_;
  Eigen::Isometry3d T_odom_vehicle_ = Eigen::Isometry3d::Identity();
  Vector x_ = Vector::Zero();  // the pose block is always 0
  Matrix P_ = Matrix::Zero();
  // Covariance of the recent part of the pose error (fading memory) with the whole state.
  RecentMatrix recent_ = RecentMatrix::Zero();
  std::array<Clone, kMaxClones> clones_;
  bool has_wheels_ = false;
};

}  // namespace infuse::motion
