#include "fusion/motion/odometry_state.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/measurement/rotation.hpp"

namespace infuse::motion {
namespace {

constexpr double kUnknownSpeedSigma = 40;             // m/s: speed unknown
constexpr double kUnknownAngularVelocitySigma = 1.5;  // rad/s: rotation unknown
constexpr double kRecentTimeConstant = 0.3;           // s of motion that a sample corrects
constexpr double kTiltRateTimeConstant = 0.2;         // s in which roll and pitch rate decay
// Of cars, steering ratios of 12 to 20, where none is stated; a stated one holds with the
// wheelbase.
constexpr double kUsualSteeringRatio = 16, kUnknownRatioSigma = 0.25, kStatedRatioSigma = 0.03;

// Standard deviations beyond which an error counts in proportion, not by its square: 95 % of a
// Gaussian's efficiency (Huber 1964).
constexpr double kTail = 1.345;

double square(double x) { return x * x; }

}  // namespace

OdometryState::OdometryState(const OdometryOptions& options) : options_(options) {
  x_[kWheelScale] = options.wheel_scale;
  P_(kYawRateBias, kYawRateBias) = square(options.yaw_bias_sigma);
  for (int i = options.planar ? 2 : 0; i < 3; ++i) {
    P_(kGyroBias + i, kGyroBias + i) = square(options.gyro_bias_sigma);
  }
  P_(kSteeringZero, kSteeringZero) = square(options.steering_zero_sigma);
  const bool stated = options.steering_ratio > 0;
  x_[kSteeringGain] = 1 / (stated ? options.steering_ratio : kUsualSteeringRatio);
  P_(kSteeringGain, kSteeringGain) =
      square(x_[kSteeringGain] * (stated ? kStatedRatioSigma : kUnknownRatioSigma));
  P_(kGnssDelay, kGnssDelay) = square(options.gnss_delay_sigma);
  P_(kYawRateDelay, kYawRateDelay) = square(options.yaw_rate_delay_sigma);
  P_(kGyroDelay, kGyroDelay) = square(options.imu_delay_sigma);
  P_(kSideSlip, kSideSlip) = square(options.side_slip_sigma);
  P_(kGnssLever, kGnssLever) = square(options.gnss_lever_sigma);
  P_(kEastHeading, kEastHeading) = square(options.east_heading_sigma);
  // The vehicle may start on a slope.
  if (!options.planar) {
    P_.block<2, 2>(kFrameTilt, kFrameTilt).diagonal().setConstant(square(options.frame_tilt_sigma));
  }
  for (int i = 0; i < 6; ++i) {
    P_(kLidarDrift + i, kLidarDrift + i) =
        square(i < 3 ? options.lidar_rotation_drift : options.lidar_translation_drift);
  }
  reset_speed_covariance();
  start_rotation();
}

void OdometryState::set_pose(const Eigen::Isometry3d& T_odom_vehicle,
                             const geometry::Matrix6& covariance) {
  T_odom_vehicle_ = T_odom_vehicle;
  x_.segment<2>(kFrameTilt).setZero();
  P_.middleRows<2>(kFrameTilt).setZero();
  P_.middleCols<2>(kFrameTilt).setZero();
  P_.topRows<6>().setZero();
  P_.leftCols<6>().setZero();
  P_.topLeftCorner<6, 6>() = covariance;
  recent_.setZero();
  clear_clones();
  reset_speed_covariance();
  start_rotation();
}

void OdometryState::reset_speed_covariance() {
  for (const int i :
       {int{kSpeed}, int{kAcceleration}, int{kLateralVelocity}, int{kVerticalVelocity}}) {
    P_.row(i).setZero();
    P_.col(i).setZero();
    recent_.col(i).setZero();
  }
  x_[kAcceleration] = 0;
  P_(kSpeed, kSpeed) = square(kUnknownSpeedSigma);
  P_(kAcceleration, kAcceleration) = 4;
  if (options_.moves_forward) return;
  P_(kLateralVelocity, kLateralVelocity) = square(kUnknownSpeedSigma);
  if (!options_.planar) P_(kVerticalVelocity, kVerticalVelocity) = square(kUnknownSpeedSigma);
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

// A vehicle pitches and rolls no faster than its random walk allows; a larger variance would let
// the first accelerations turn the vehicle, by degrees, instead of the frame.
void OdometryState::start_rotation() {
  reset_rotation_covariance();
  if (options_.planar || !options_.moves_forward) return;
  x_.segment<2>(kAngularVelocity).setZero();
  P_.block<2, 2>(kAngularVelocity, kAngularVelocity)
      .diagonal()
      .setConstant(0.5 * kTiltRateTimeConstant * square(options_.tilt_rate_walk));
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
  start_rotation();
}

// The acceleration was wrong by a constant: one direction of the state.
void OdometryState::release_acceleration(double seconds) {
  constexpr double kSigma = 10;  // m/s (decision 17)
  Vector direction = Vector::Zero();
  direction[kAcceleration] = kSigma;
  direction[kSpeed] = kSigma * seconds;
  direction.head<6>() =
      0.5 * kSigma * square(seconds) * x_[kWheelScale] * geometry::adjoint(T_odom_vehicle_).col(3);
  P_ += direction * direction.transpose();
  recent_ += direction.head<6>() * direction.head<kMotionSize>().transpose();
}

void OdometryState::release_heading() {
  constexpr double kUnknownHeading = 10;  // rad, derived from π: any heading
  set_parameter(kEastHeading, {x_[kEastHeading], kUnknownHeading});
  set_parameter(kYawRateBias, {x_[kYawRateBias], options_.yaw_bias_sigma});
  set_parameter(kGyroBias + 2, {x_[kGyroBias + 2], options_.gyro_bias_sigma});
}

void OdometryState::predict(double seconds) {
  constexpr double kAccelerationTimeConstant = 2;  // s
  const double dt = seconds;
  geometry::Vector6 twist = geometry::Vector6::Zero();
  twist.head<3>() = x_.segment<3>(kAngularVelocity);
  const double wheels = x_[kSpeed] + 0.5 * dt * x_[kAcceleration], scale = x_[kWheelScale];
  twist.tail<3>() << scale * wheels, x_[kLateralVelocity], x_[kVerticalVelocity];

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
  F.block<6, 2>(kPose, kLateralVelocity) = gain.rightCols<2>();
  F(kSpeed, kAcceleration) = dt;
  F(kAcceleration, kAcceleration) = decay;
  F(kSteeringZero, kSteeringZero) = steering_zero_decay;
  F(kAngularVelocity, kAngularVelocity) = F(kAngularVelocity + 1, kAngularVelocity + 1) =
      tilt_decay;
  F.block<6, 6>(kLidarDrift, kLidarDrift) *= drift_decay;

  T_odom_vehicle_ = T_odom_vehicle_ * geometry::exp(twist * dt);
  T_odom_vehicle_.linear() = orthonormal(T_odom_vehicle_.linear());
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
    P_(kLateralVelocity, kLateralVelocity) += square(options_.velocity_walk) * dt;
    if (!options_.planar)
      P_(kVerticalVelocity, kVerticalVelocity) += square(options_.velocity_walk) * dt;
  }
  P_(kYawRateBias, kYawRateBias) += square(options_.bias_walk) * dt;
  for (int i = options_.planar ? 2 : 0; i < 3; ++i) {
    const double walk = i < 2 ? options_.tilt_rate_walk : options_.angular_velocity_walk;
    P_(kAngularVelocity + i, kAngularVelocity + i) += square(walk) * dt;
    P_(kGyroBias + i, kGyroBias + i) += square(options_.bias_walk) * dt;
  }
  if (has_wheels_) P_(kWheelScale, kWheelScale) += square(options_.wheel_scale_walk) * dt;
  P_(kGnssDelay, kGnssDelay) += square(options_.delay_walk) * dt;
  P_(kSteeringZero, kSteeringZero) +=
      square(options_.steering_zero_sigma) * (1 - steering_zero_decay * steering_zero_decay);
  for (int i = 0; i < 6; ++i) {
    P_(kLidarDrift + i, kLidarDrift + i) +=
        square(i < 3 ? options_.lidar_rotation_drift : options_.lidar_translation_drift) *
        (1 - drift_decay * drift_decay);
  }
}

bool OdometryState::update(double innovation, const Vector& derivative, double noise, double gate,
                           bool of_rate) {
  const Vector PH = P_ * derivative;
  const double stated = derivative.dot(PH) + square(noise);
  if (!(square(innovation) <= square(gate) * stated)) return false;  // NaN too
  const double sigmas = std::abs(innovation) / std::sqrt(stated);
  const double variance = stated + square(noise) * std::max(0.0, sigmas / kTail - 1);
  const geometry::Vector6 recent_PH = recent_ * derivative.head<kMotionSize>();
  Vector gain = PH / variance;
  geometry::Vector6 recent_gain = recent_PH / variance;
  if (of_rate) {
    // As if the delays were known, P − P_d P_dd⁻¹ P_dᵀ: rates fit any delay, and the noise of their
    // change would choose the weights.
    constexpr double kLeast = 1e-18;  // s², of a delay that is known: double precision
    const auto P_delays = P_.middleCols<2>(kYawRateDelay);
    const auto of_delays = derivative.segment<2>(kYawRateDelay);
    const Eigen::Matrix2d delays =
        P_delays.middleRows<2>(kYawRateDelay) + kLeast * Eigen::Matrix2d::Identity();
    const Eigen::Vector2d left_out =
        of_delays + delays.inverse() * (PH - P_delays * of_delays).segment<2>(kYawRateDelay);
    gain = PH - P_delays * left_out;
    const double known = derivative.dot(gain) - of_delays.dot(gain.segment<2>(kYawRateDelay));
    const double its = known + square(noise) + variance - stated;
    gain /= its;
    recent_gain = (recent_PH - recent_.middleCols<2>(kYawRateDelay) * left_out) / its;
  }
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
  constexpr int kRest = kMotionSize - 6;
  recent_.rightCols<kRest>() -=
      recent_gain * PH.segment<kRest>(6).transpose() +
      (recent_PH - variance * recent_gain) * gain.segment<kRest>(6).transpose();
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

void OdometryState::set_parameter(int index, const EstimatedParameter& known) {
  x_[index] = known.value;
  P_.row(index).setZero();
  P_.col(index).setZero();
  recent_.col(index).setZero();
  P_(index, index) = square(known.sigma);
}

EstimatedParameter OdometryState::parameter(int index) const {
  return {x_[index], std::sqrt(std::max(0.0, P_(index, index)))};
}

}  // namespace infuse::motion
