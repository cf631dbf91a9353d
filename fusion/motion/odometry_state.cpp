#include "fusion/motion/odometry_state.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/measurement/angles.hpp"
#include "fusion/geometry/plane_length.hpp"

namespace infuse::motion {
namespace {

constexpr double kGateSigmas = 4;  // standard deviations beyond which a sample is rejected
constexpr double kNoGateSigmas = 1e9;
constexpr double kGravity = 9.80665;                  // m/s²
constexpr double kUnknownSpeedSigma = 40;             // m/s: speed unknown
constexpr double kUnknownAngularVelocitySigma = 1.5;  // rad/s: rotation unknown
constexpr double kRecentTimeConstant = 0.3;           // s of motion that a sample corrects

double square(double x) { return x * x; }

}  // namespace

std::optional<std::string> OdometryOptions::invalid() const {
  if (!(wheelbase > 0 && wheelbase < 30) || !(track > 0 && track < 10)) {
    return "wheelbase and track must be positive, and less than 30 and 10 m";
  }
  if (!(steering_ratio >= 0 && steering_ratio < 1000))
    return "steering_ratio must lie in 0 ... 1000";
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
       {acceleration_walk, angular_velocity_walk, tilt_rate_walk, translation_walk, rotation_walk,
        yaw_bias_sigma, gyro_bias_sigma, bias_walk, wheel_scale_sigma, wheel_scale_walk,
        steering_zero_sigma, east_heading_sigma, lidar_rotation_drift, lidar_translation_drift,
        velocity_walk}) {
    if (!(sigma >= 0)) return "a standard deviation must not be negative";
  }
  return std::nullopt;
}

OdometryState::OdometryState(const OdometryOptions& options) : options_(options) {
  x_[kWheelScale] = options.wheel_scale;
  P_(kYawRateBias, kYawRateBias) = square(options.yaw_bias_sigma);
  for (int i = options.planar ? 2 : 0; i < 3; ++i) {
    P_(kGyroBias + i, kGyroBias + i) = square(options.gyro_bias_sigma);
  }
  P_(kSteeringZero, kSteeringZero) = square(options.steering_zero_sigma);
  P_(kEastHeading, kEastHeading) = square(options.east_heading_sigma);
  for (int i = 0; i < 6; ++i) {
    P_(kLidarDrift + i, kLidarDrift + i) =
        square(i < 3 ? options.lidar_rotation_drift : options.lidar_translation_drift);
  }
  reset_speed_covariance();
  reset_rotation_covariance();
}

void OdometryState::set_pose(const Eigen::Isometry3d& T_odom_vehicle,
                             const geometry::Matrix6& covariance) {
  T_odom_vehicle_ = T_odom_vehicle;
  P_.topRows<6>().setZero();
  P_.leftCols<6>().setZero();
  P_.topLeftCorner<6, 6>() = covariance;
  recent_.setZero();
  clear_clones();
  reset_speed_covariance();
  reset_rotation_covariance();
}

void OdometryState::reset_speed_covariance() {
  for (const int i : {int{kSpeed}, int{kAcceleration}, int{kAcross}, int{kUp}}) {
    P_.row(i).setZero();
    P_.col(i).setZero();
    recent_.col(i).setZero();
  }
  x_[kAcceleration] = 0;
  P_(kSpeed, kSpeed) = square(kUnknownSpeedSigma);
  P_(kAcceleration, kAcceleration) = 4;
  if (options_.moves_forward) return;
  P_(kAcross, kAcross) = square(kUnknownSpeedSigma);
  if (!options_.planar) P_(kUp, kUp) = square(kUnknownSpeedSigma);
}

void OdometryState::reset_rotation_covariance() {
  for (int i = kAngularVelocity; i < kAngularVelocity + 3; ++i) {
    P_.row(i).setZero();
    P_.col(i).setZero();
    recent_.col(i).setZero();
    if (i == kAngularVelocity + 2 || !options_.planar)
      P_(i, i) = square(kUnknownAngularVelocitySigma);
  }
}

void OdometryState::reset_motion(double seconds) {
  constexpr double kUnseenYawRate = 0.3,
                   kUnseenSpeed = 20;  // rad/s, m/s: possible unseen motion
  const double yaw_variance = square(std::min(kUnseenYawRate * seconds, std::numbers::pi));
  const double tilt = options_.planar ? 0 : 0.1 * yaw_variance;
  const double position_variance = square(kUnseenSpeed * seconds);
  geometry::Vector6 unseen;
  unseen << tilt, tilt, yaw_variance, position_variance, position_variance,
      options_.planar ? 0 : 0.01 * position_variance;
  P_.topLeftCorner<6, 6>() += geometry::transform_covariance(T_odom_vehicle_, unseen.asDiagonal());
  reset_speed_covariance();
  reset_rotation_covariance();
}

void OdometryState::predict(double seconds) {
  constexpr double kAccelerationTimeConstant = 2, kTiltRateTimeConstant = 0.2;  // s
  const double dt = seconds;
  geometry::Vector6 twist = geometry::Vector6::Zero();
  twist.head<3>() = x_.segment<3>(kAngularVelocity);
  const double wheels = x_[kSpeed] + 0.5 * dt * x_[kAcceleration], scale = x_[kWheelScale];
  twist.tail<3>() << scale * wheels, x_[kAcross], x_[kUp];

  // exp((τ + δ) dt) ≈ exp(J δ dt) exp(τ dt): an error of the motion enters the pose through T and
  // J; the pose error itself is unchanged.
  const geometry::Matrix6 gain =
      geometry::adjoint(T_odom_vehicle_) * geometry::left_jacobian(twist * dt) * dt;
  const double decay = std::exp(-dt / kAccelerationTimeConstant);
  const double steering_zero_decay =
      std::exp(-dt / to_seconds(options_.steering_zero_time_constant));
  const double tilt_decay = std::exp(-dt / kTiltRateTimeConstant);
  const double drift_decay = std::exp(-dt / to_seconds(options_.lidar_drift_time_constant));
  MotionMatrix F = MotionMatrix::Identity();
  F.block<6, 3>(kPose, kAngularVelocity) = gain.leftCols<3>();
  F.block<6, 1>(kPose, kSpeed) = scale * gain.col(3);
  F.block<6, 1>(kPose, kAcceleration) = 0.5 * dt * scale * gain.col(3);
  F.block<6, 1>(kPose, kWheelScale) = wheels * gain.col(3);
  F.block<6, 2>(kPose, kAcross) = gain.rightCols<2>();
  F(kSpeed, kAcceleration) = dt;
  F(kAcceleration, kAcceleration) = decay;
  F(kSteeringZero, kSteeringZero) = steering_zero_decay;
  F(kAngularVelocity, kAngularVelocity) = F(kAngularVelocity + 1, kAngularVelocity + 1) =
      tilt_decay;
  F.block<6, 6>(kLidarDrift, kLidarDrift) *= drift_decay;

  T_odom_vehicle_ = T_odom_vehicle_ * geometry::exp(twist * dt);
  // Renormalise the rotation, which drifts over millions of steps.
  T_odom_vehicle_.linear() = Eigen::Quaterniond(T_odom_vehicle_.linear()).normalized().matrix();
  x_[kSpeed] += dt * x_[kAcceleration];
  x_[kAcceleration] *= decay;
  x_[kSteeringZero] *= steering_zero_decay;
  x_.segment<2>(kAngularVelocity) *= tilt_decay;
  x_.segment<6>(kLidarDrift) *= drift_decay;

  // New pose error is added to the recent part, which fades.
  const MotionMatrix PFt = P_.topLeftCorner<kMotionSize, kMotionSize>() * F.transpose();
  recent_ = std::exp(-dt / kRecentTimeConstant) * (recent_ * F.transpose()).eval();
  recent_ += F.topRightCorner<6, kMotionSize - 6>() * PFt.bottomRows<kMotionSize - 6>();
  P_.topLeftCorner<kMotionSize, kMotionSize>() = F * PFt;
  constexpr int kCloneSize = kSize - kMotionSize;
  P_.topRightCorner<kMotionSize, kCloneSize>() =
      (F * P_.topRightCorner<kMotionSize, kCloneSize>()).eval();
  P_.bottomLeftCorner<kCloneSize, kMotionSize>() =
      P_.topRightCorner<kMotionSize, kCloneSize>().transpose();
  if (is_moving()) {
    geometry::Vector6 unseen;
    const double tilt = options_.planar ? 0 : square(options_.rotation_walk);
    const double slip = square(options_.translation_walk);
    unseen << tilt, tilt, square(options_.rotation_walk), slip, slip, options_.planar ? 0 : slip;
    P_.topLeftCorner<6, 6>() +=
        geometry::transform_covariance(T_odom_vehicle_, (unseen * dt).asDiagonal());
  }
  P_(kSpeed, kSpeed) += square(options_.acceleration_walk) * dt * dt * dt / 3;
  P_(kAcceleration, kAcceleration) += square(options_.acceleration_walk) * dt;
  if (!options_.moves_forward) {
    P_(kAcross, kAcross) += square(options_.velocity_walk) * dt;
    if (!options_.planar) P_(kUp, kUp) += square(options_.velocity_walk) * dt;
  }
  P_(kYawRateBias, kYawRateBias) += square(options_.bias_walk) * dt;
  for (int i = options_.planar ? 2 : 0; i < 3; ++i) {
    const double walk = i < 2 ? options_.tilt_rate_walk : options_.angular_velocity_walk;
    P_(kAngularVelocity + i, kAngularVelocity + i) += square(walk) * dt;
    P_(kGyroBias + i, kGyroBias + i) += square(options_.bias_walk) * dt;
  }
  if (has_wheels_) P_(kWheelScale, kWheelScale) += square(options_.wheel_scale_walk) * dt;
  P_(kSteeringZero, kSteeringZero) +=
      square(options_.steering_zero_sigma) * (1 - steering_zero_decay * steering_zero_decay);
  for (int i = 0; i < 6; ++i) {
    P_(kLidarDrift + i, kLidarDrift + i) +=
        square(i < 3 ? options_.lidar_rotation_drift : options_.lidar_translation_drift) *
        (1 - drift_decay * drift_decay);
  }
}

bool OdometryState::update(double innovation, const Vector& derivative, double noise, double gate) {
  const Vector PH = P_ * derivative;
  const double variance = derivative.dot(PH) + square(noise);
  if (!(square(innovation) <= square(gate) * variance)) return false;  // NaN too
  Vector gain = PH / variance;
  const geometry::Vector6 recent_gain = recent_ * derivative.head<kMotionSize>() / variance;
  if (is_moving() || !derivative.head<3>().isZero(0)) {
    keep_position(recent_gain, gain);
  } else {
    gain.head<6>() = recent_gain;
    gain.tail<kSize - kMotionSize>().setZero();
  }
  apply(gain * innovation);
  // Holds for any gain: P − KHP − PHᵀKᵀ + K(HPHᵀ + R)Kᵀ.
  const Matrix lost = gain * PH.transpose();
  P_ += variance * gain * gain.transpose() - lost - lost.transpose();
  P_ = (0.5 * (P_ + P_.transpose())).eval();
  // Only its part with the motion is used.
  recent_.rightCols<kMotionSize - 6>() -= recent_gain * PH.segment<kMotionSize - 6>(6).transpose();
  return true;
}

// A sample tells about the path since the start too: it would turn about the origin with a measured
// course, and stretch with a measured speed, if heading and wheel scale were as wrong before. The
// vehicle would step by decimetres. But the older path is in motions that were reported: the frame
// turns about the vehicle, which moves only by the error of its recent motion.
void OdometryState::keep_position(const geometry::Vector6& recent_gain, Vector& gain) const {
  const Eigen::Vector3d position = T_odom_vehicle_.translation();
  for (int i = 0; i < kSize; i = i == 0 ? static_cast<int>(kMotionSize) : i + 6) {
    const Eigen::Vector3d rotation = gain.segment<3>(i);
    gain.segment<3>(i + 3) = position.cross(rotation);
  }
  gain.segment<3>(3) += recent_gain.head<3>().cross(position) + recent_gain.tail<3>();
}

void OdometryState::apply(const Vector& change) {
  T_odom_vehicle_ = geometry::exp(change.head<6>()) * T_odom_vehicle_;
  x_.segment<kMotionSize - 6>(6) += change.segment<kMotionSize - 6>(6);
  for (size_t i = 0; i < kMaxClones; ++i) {
    Eigen::Isometry3d& clone = clones_[i].T_odom_vehicle;
    clone = geometry::exp(change.segment<6>(kMotionSize + 6 * static_cast<int>(i))) * clone;
  }
}

// The centre of the rear axle moves along x. The speed of a wheel differs by the turning, which is
// taken as known: radii and track are too uncertain to estimate rotation from the wheels, or the
// wheel scale from rotation.
double OdometryState::expected_wheel_speed(size_t wheel) const {
  const double rate = x_[kAngularVelocity + 2];
  const double side = wheel % 2 == 0 ? 0.5 * options_.track : -0.5 * options_.track;
  const double along = x_[kSpeed] - rate * side;
  const double across = wheel < 2 ? rate * options_.wheelbase : 0;
  return std::copysign(geometry::plane_length(along, across), along);
}

// Without wheels their scale would take a part of every change of the speed.
int OdometryState::update_wheels(const WheelOdometry& sample) {
  if (!has_wheels_) {
    has_wheels_ = true;
    P_(kWheelScale, kWheelScale) = square(options_.wheel_scale_sigma);
  }
  int accepted = 0;
  for (size_t i = 0; i < 4; ++i) {
    const double measured = sample.wheel_speed[i];
    if (!std::isfinite(measured)) continue;
    Vector H = Vector::Zero();
    H[kSpeed] = 1;
    accepted += update(measured - expected_wheel_speed(i), H, options_.wheel_noise, kGateSigmas);
  }
  if (std::isfinite(sample.speed)) {
    Vector H = Vector::Zero();
    H[kSpeed] = 1;
    accepted += update(sample.speed - x_[kSpeed], H, options_.wheel_noise, kGateSigmas);
  }
  return accepted;
}

bool OdometryState::agrees(const WheelOdometry& sample, double tolerance) const {
  for (size_t i = 0; i < 4; ++i) {
    if (std::abs(sample.wheel_speed[i] - expected_wheel_speed(i)) <= tolerance) return true;
  }
  return std::abs(sample.speed - x_[kSpeed]) <= tolerance;
}

bool OdometryState::update_yaw_rate(double yaw_rate) {
  Vector H = Vector::Zero();
  H[kAngularVelocity + 2] = H[kYawRateBias] = 1;
  return update(yaw_rate - x_[kAngularVelocity + 2] - x_[kYawRateBias], H, options_.yaw_rate_noise,
                kGateSigmas);
}

bool OdometryState::update_gyro(const ImuSample& sample) {
  return update_gyro(AngularVelocity{sample.stamp, sample.angular_velocity, options_.gyro_noise});
}

bool OdometryState::update_gyro(const AngularVelocity& measured) {
  bool accepted = true;
  for (int i = options_.planar ? 2 : 0; i < 3; ++i) {
    if (!std::isfinite(measured.value[static_cast<size_t>(i)])) continue;
    Vector H = Vector::Zero();
    H[kAngularVelocity + i] = H[kGyroBias + i] = 1;
    const double expected = x_[kAngularVelocity + i] + x_[kGyroBias + i];
    accepted =
        update(measured.value[static_cast<size_t>(i)] - expected, H, measured.noise, kGateSigmas) &&
        accepted;
  }
  return accepted;
}

bool OdometryState::update_gravity(const ImuSample& sample) {
  if (options_.planar) return false;
  // Specific force: acceleration of the motion plus the reaction to gravity, in vehicle axes.
  const Eigen::Matrix3d R_vehicle_odom = T_odom_vehicle_.linear().transpose();
  const Eigen::Vector3d up = R_vehicle_odom.col(2);
  const Eigen::Matrix3d by_rotation =
      kGravity * R_vehicle_odom * geometry::skew(Eigen::Vector3d::UnitZ());
  const double v = speed(), rate = x_[kAngularVelocity + 2], scale = x_[kWheelScale];
  const double expected[2] = {scale * x_[kAcceleration] + kGravity * up.x(),
                              rate * v + kGravity * up.y()};
  bool accepted = true;
  for (int i = 0; i < 2; ++i) {
    Vector H = Vector::Zero();
    H.head<3>() = by_rotation.row(i).transpose();
    if (i == 0) {
      H[kAcceleration] = scale;
    } else {
      H[kSpeed] = rate * scale;
      H[kAngularVelocity + 2] = v;
    }
    accepted = update(sample.linear_acceleration[static_cast<size_t>(i)] - expected[i], H,
                      options_.acceleration_noise, kGateSigmas) &&
               accepted;
  }
  return accepted;
}

bool OdometryState::update_steering(double steering_angle) {
  constexpr double kMaxBicycleSteeringAngle = 0.5;  // rad at the steering wheel; range of the
                                                    // bicycle model
  if (options_.steering_ratio <= 0 || !(std::abs(steering_angle) < kMaxBicycleSteeringAngle))
    return false;
  const double v = speed();
  const double response = v / (options_.steering_ratio * options_.wheelbase *
                               (1 + square(v / options_.characteristic_speed)));
  Vector H = Vector::Zero();
  H[kAngularVelocity + 2] = 1;
  H[kSteeringZero] = response;
  const double expected = x_[kAngularVelocity + 2] + response * x_[kSteeringZero];
  if (!update(response * steering_angle - expected, H, options_.steering_noise, kGateSigmas)) {
    return false;
  }
  // Roads are straight on average; so is the steering at speed.
  constexpr double kMinStraightSpeed = 8, kMaxStraightSteeringAngle = 0.1;  // m/s, rad
  if (std::abs(v) > kMinStraightSpeed &&
      std::abs(steering_angle - x_[kSteeringZero]) < kMaxStraightSteeringAngle) {
    H.setZero();
    H[kSteeringZero] = 1;
    update(steering_angle - x_[kSteeringZero], H, options_.straight_steering_noise, kGateSigmas);
  }
  return true;
}

bool OdometryState::update_gnss_speed(double measured, double noise) {
  return update(measured - driving_direction() * speed(), speed_derivative(), noise, kGateSigmas);
}

// The acceleration was wrong by a constant: one direction of the state.
void OdometryState::release_acceleration(double seconds) {
  constexpr double kSigma = 10;  // m/s²
  Vector direction = Vector::Zero();
  direction[kAcceleration] = kSigma;
  direction[kSpeed] = kSigma * seconds;
  direction.head<6>() =
      0.5 * kSigma * square(seconds) * x_[kWheelScale] * geometry::adjoint(T_odom_vehicle_).col(3);
  P_ += direction * direction.transpose();
  recent_ += direction.head<6>() * direction.head<kMotionSize>().transpose();
}

// A receiver does not tell forward from reverse. A speed that is not known yet is near 0 with
// either sign: the vehicle drives forward unless its speed is known to be negative.
double OdometryState::driving_direction() const {
  constexpr double kReverseSigmas = 2;
  const bool reverse =
      options_.moves_forward && x_[kSpeed] < -kReverseSigmas * std::sqrt(P_(kSpeed, kSpeed));
  return reverse ? -1 : 1;
}

OdometryState::Vector OdometryState::speed_derivative() const {
  Eigen::Vector3d direction(driving_direction(), 0, 0);
  if (!options_.moves_forward && is_moving()) direction = velocity().normalized();
  Vector H = Vector::Zero();
  H[kSpeed] = x_[kWheelScale] * direction.x();
  H[kWheelScale] = x_[kSpeed] * direction.x();
  H[kAcross] = direction.y();
  H[kUp] = direction.z();
  return H;
}

double OdometryState::speed_sigma() const {
  Vector H = speed_derivative();
  H[kWheelScale] = 0;
  return std::sqrt(H.dot(P_ * H));
}

bool OdometryState::update_gnss_course(double course) {
  constexpr double kFullCourseSpeed = 10;  // m/s
  Vector H = Vector::Zero();
  H[kPose + 2] = H[kEastHeading] = 1;
  Eigen::Vector3d ahead = T_odom_vehicle_.linear().col(0);
  if (!options_.moves_forward) {
    ahead = T_odom_vehicle_.linear() * velocity();
    const Eigen::RowVector3d by_velocity = Eigen::RowVector3d(-ahead.y(), ahead.x(), 0) /
                                           ahead.head<2>().squaredNorm() * T_odom_vehicle_.linear();
    H[kSpeed] = x_[kWheelScale] * by_velocity.x();
    H.segment<2>(kAcross) = by_velocity.tail<2>().transpose();
  }
  const double heading = std::atan2(ahead.y(), ahead.x()) + x_[kEastHeading];
  const double noise =
      options_.gnss_course_noise * std::max(1.0, kFullCourseSpeed / std::abs(speed()));
  return update(wrap_angle(std::numbers::pi / 2 - course - heading), H, noise, kGateSigmas);
}

bool OdometryState::update_slow_turn() {
  constexpr double kMinTurningRadius = 5;  // m
  Vector H = Vector::Zero();
  H[kAngularVelocity + 2] = 1;
  const double noise = 0.01 + (std::abs(speed()) + speed_sigma()) / kMinTurningRadius;
  return update(-x_[kAngularVelocity + 2], H, noise, kNoGateSigmas);
}

void OdometryState::update_standstill() {
  constexpr double kSpeedNoise = 0.01;      // m/s
  constexpr double kRotationNoise = 0.002;  // rad/s, for doors and wind
  Vector H = Vector::Zero();
  H[kSpeed] = 1;
  update(-x_[kSpeed], H, kSpeedNoise, kNoGateSigmas);
  for (const int i : {int{kAcross}, int{kUp}}) {
    if (options_.moves_forward) break;
    H.setZero();
    H[i] = 1;
    update(-x_[i], H, kSpeedNoise, kNoGateSigmas);
  }
  H.setZero();
  H[kAcceleration] = 1;
  update(-x_[kAcceleration], H, 0.1, kNoGateSigmas);
  for (int i = options_.planar ? 2 : 0; i < 3; ++i) {
    H.setZero();
    H[kAngularVelocity + i] = 1;
    update(-x_[kAngularVelocity + i], H, kRotationNoise, kNoGateSigmas);
  }
}

EstimatedParameter OdometryState::parameter(int index) const {
  return {x_[index], std::sqrt(std::max(0.0, P_(index, index)))};
}

}  // namespace infuse::motion
