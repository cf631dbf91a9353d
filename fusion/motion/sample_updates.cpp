// The part of `OdometryState` that updates it with one sample of a sensor, or with what is known
// of the motion.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/measurement/angles.hpp"
#include "fusion/geometry/plane_length.hpp"
#include "fusion/motion/odometry_sources.hpp"
#include "fusion/motion/odometry_state.hpp"

namespace infuse::motion {
namespace {

constexpr double kNoGateSigmas = 1e9;  // no gate by definition
constexpr double kGravity = 9.80665;   // m/s², standard gravity

}  // namespace

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
    P_(kWheelScale, kWheelScale) = options_.wheel_scale_sigma * options_.wheel_scale_sigma;
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

EstimatedParameter OdometryState::speed_error(const WheelOdometry& sample) const {
  double nearest = sample.speed - x_[kSpeed];
  for (size_t i = 0; i < 4; ++i) {
    const double error = sample.wheel_speed[i] - expected_wheel_speed(i);
    if (std::isnan(nearest) || std::abs(error) < std::abs(nearest)) nearest = error;
  }
  const double by_scale = x_[kSpeed] * parameter(kWheelScale).sigma;
  return {x_[kWheelScale] * nearest, std::hypot(options_.wheel_noise, by_scale)};
}

// A rate that is late is one of before: the error of the rotation follows from that of the delay.
// What that is, another source of rotation shows; rates alone fit any delay.
bool OdometryState::update_late_rate(double rate, double noise, double change, int bias,
                                     int delay) {
  Vector H = Vector::Zero();
  H[kAngularVelocity + 2] = H[bias] = 1;
  H[delay] = -change;
  const double expected = x_[kAngularVelocity + 2] + x_[bias] - change * x_[delay];
  return update(rate - expected, H, noise, kGateSigmas, true);
}

bool OdometryState::update_yaw_rate(double yaw_rate, double change) {
  return update_late_rate(yaw_rate, options_.yaw_rate_noise, change, kYawRateBias, kYawRateDelay);
}

// Roll and pitch shake: their changes are noise.
bool OdometryState::update_gyro(const Eigen::Vector3d& rate, double noise, double change) {
  bool accepted = true;
  for (int i = options_.planar ? 2 : 0; i < 2; ++i) {
    if (!std::isfinite(rate[i])) continue;
    Vector H = Vector::Zero();
    H[kAngularVelocity + i] = H[kGyroBias + i] = 1;
    const double expected = x_[kAngularVelocity + i] + x_[kGyroBias + i];
    accepted = update(rate[i] - expected, H, noise, kGateSigmas) && accepted;
  }
  if (!std::isfinite(rate[2])) return accepted;
  return update_late_rate(rate[2], noise, change, kGyroBias + 2, kGyroDelay) && accepted;
}

bool OdometryState::update_gravity(const ImuSample& sample) {
  if (options_.planar) return false;
  // Specific force: acceleration of the motion plus the reaction to gravity, in vehicle axes.
  const Eigen::Matrix3d R_vehicle_odom = T_odom_vehicle_.linear().transpose();
  const Eigen::Vector3d up_odom =
      geometry::rotation_exp({x_[kFrameTilt], x_[kFrameTilt + 1], 0}).col(2);
  const Eigen::Vector3d up = R_vehicle_odom * up_odom;
  const Eigen::Matrix3d by_rotation = kGravity * R_vehicle_odom * geometry::skew(up_odom);
  const double v = speed(), rate = x_[kAngularVelocity + 2], scale = x_[kWheelScale];
  const double expected[2] = {scale * x_[kAcceleration] + kGravity * up.x(),
                              rate * v + kGravity * up.y()};
  bool accepted = true;
  for (int i = 0; i < 2; ++i) {
    Vector H = Vector::Zero();
    H.head<3>() = by_rotation.row(i).transpose();
    H.segment<2>(kFrameTilt) = -by_rotation.row(i).head<2>().transpose();
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
                                                    // bicycle model (decision 17)
  if (!(std::abs(steering_angle) < kMaxBicycleSteeringAngle)) return false;
  const double v = speed();
  const double relative_speed = v / options_.characteristic_speed;
  const double response = v / (options_.wheelbase * (1 + relative_speed * relative_speed));
  const double angle = steering_angle - x_[kSteeringZero];
  Vector H = Vector::Zero();
  H[kAngularVelocity + 2] = 1;
  H[kSteeringZero] = response * x_[kSteeringGain];
  H[kSteeringGain] = -response * angle;
  if (!update(response * x_[kSteeringGain] * angle - x_[kAngularVelocity + 2], H,
              options_.steering_noise, kGateSigmas)) {
    return false;
  }
  // Roads are straight on average; so is the steering at speed.
  constexpr double kMinStraightSpeed = 8,
                   kMaxStraightSteeringAngle = 0.1;  // m/s, rad (decision 17)
  if (std::abs(v) > kMinStraightSpeed &&
      std::abs(steering_angle - x_[kSteeringZero]) < kMaxStraightSteeringAngle) {
    H.setZero();
    H[kSteeringZero] = 1;
    update(steering_angle - x_[kSteeringZero], H, options_.straight_steering_noise, kGateSigmas);
  }
  return true;
}

bool OdometryState::update_gnss_speed(double measured, double noise) {
  Vector H = speed_derivative();
  H[kGnssDelay] = -driving_direction() * x_[kWheelScale] * x_[kAcceleration];
  const double error = driving_direction() * gnss_speed_error(measured, noise).value;
  return update(error, H, noise, kGateSigmas);
}

EstimatedParameter OdometryState::gnss_speed_error(double measured, double noise) const {
  const double by_delay = x_[kWheelScale] * x_[kAcceleration];  // per second that it is late
  const double late = by_delay * x_[kGnssDelay];
  return {driving_direction() * measured - speed() + late,
          std::hypot(noise, by_delay * parameter(kGnssDelay).sigma)};
}

// A receiver does not tell forward from reverse. A speed that is not known yet is near 0 with
// either sign: the vehicle drives forward unless its speed is known to be negative.
double OdometryState::driving_direction() const {
  constexpr double kReverseSigmas = 2;  // 97.7 % of a Gaussian
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
  H[kLateralVelocity] = direction.y();
  H[kVerticalVelocity] = direction.z();
  return H;
}

double OdometryState::speed_sigma() const {
  Vector H = speed_derivative();
  H[kWheelScale] = 0;
  return std::sqrt(H.dot(P_ * H));
}

bool OdometryState::update_gnss_course(double course, double course_noise) {
  constexpr double kFullCourseSpeed = 10;  // m/s (decision 17)
  Vector H = Vector::Zero();
  H[kPose + 2] = H[kEastHeading] = 1;
  Eigen::Vector3d ahead = T_odom_vehicle_.linear().col(0);
  if (!options_.moves_forward) {
    ahead = T_odom_vehicle_.linear() * velocity();
    const Eigen::RowVector3d by_velocity = Eigen::RowVector3d(-ahead.y(), ahead.x(), 0) /
                                           ahead.head<2>().squaredNorm() * T_odom_vehicle_.linear();
    H[kSpeed] = x_[kWheelScale] * by_velocity.x();
    H.segment<2>(kLateralVelocity) = by_velocity.tail<2>().transpose();
  }
  // The receiver moves in another direction than the rear axle points: the tyres slip across, and
  // it is ahead of the axle, which a turn carries sideways. What it states is late.
  const double rate = x_[kAngularVelocity + 2];
  H[kSideSlip] = rate * speed();
  H[kGnssLever] = rate / speed();
  H[kGnssDelay] = -rate;
  const double course_of_turn = H[kSideSlip] * x_[kSideSlip] + H[kGnssLever] * x_[kGnssLever] +
                                H[kGnssDelay] * x_[kGnssDelay];
  const double heading = std::atan2(ahead.y(), ahead.x()) + x_[kEastHeading] + course_of_turn;
  const double error = wrap_angle(std::numbers::pi / 2 - course - heading);
  const double slow = std::max(1.0, kFullCourseSpeed / std::abs(speed()));
  // One course errs by its own noise, however little more many of them tell.
  const double of_one = options_.gnss_course_noise * slow;
  if (std::abs(error) > kGateSigmas * std::sqrt(H.dot(P_ * H) + of_one * of_one)) return false;
  return update(error, H, course_noise * slow, kGateSigmas);
}

bool OdometryState::update_slow_turn() {
  constexpr double kMinTurningRadius = 5;  // m (decision 17)
  Vector H = Vector::Zero();
  H[kAngularVelocity + 2] = 1;
  const double noise = 0.01 + (std::abs(speed()) + speed_sigma()) / kMinTurningRadius;
  return update(-x_[kAngularVelocity + 2], H, noise, kNoGateSigmas);
}

// A vehicle that turns does not stand, though its wheels do: it slides, or is carried.
void OdometryState::update_standstill() {
  constexpr double kSpeedNoise = 0.01;      // m/s (decision 17)
  constexpr double kRotationNoise = 0.002;  // rad/s, for doors and wind (decision 17)
  for (int i = 2; i >= (options_.planar ? 2 : 0); --i) {
    Vector H = Vector::Zero();
    H[kAngularVelocity + i] = 1;
    if (!update(-x_[kAngularVelocity + i], H, kRotationNoise, kGateSigmas)) return;
  }
  Vector H = Vector::Zero();
  H[kSpeed] = 1;
  update(-x_[kSpeed], H, kSpeedNoise, kNoGateSigmas);
  for (const int i : {int{kLateralVelocity}, int{kVerticalVelocity}}) {
    if (options_.moves_forward) break;
    H.setZero();
    H[i] = 1;
    update(-x_[i], H, kSpeedNoise, kNoGateSigmas);
  }
  H.setZero();
  H[kAcceleration] = 1;
  update(-x_[kAcceleration], H, 0.1, kNoGateSigmas);
}

}  // namespace infuse::motion
