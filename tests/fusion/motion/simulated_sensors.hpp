#pragma once

#include <cmath>
#include <numbers>
#include <random>

#include "fusion/motion/odometry_filter.hpp"
#include "tests/fusion/motion/true_drive.hpp"

namespace infuse::motion {

/// Town drive that starts at speed: winding, with slopes, at 9 to 15 m/s.
inline TrueDrive town_drive(double length, double phase = 0, TrueDrive::TwistFunction unseen = {}) {
  const auto twist = [phase](double t) {
    geometry::Vector6 now = geometry::Vector6::Zero();
    now[0] = 0.01 * std::sin(1.1 * t + phase);
    now[1] = 0.012 * std::cos(0.8 * t + phase);
    now[2] = 0.25 * std::sin(0.4 * t + phase);
    now[3] = 12 + 3 * std::sin(0.3 * t + 2 * phase);
    return now;
  };
  return TrueDrive(length, twist, std::move(unseen));
}

/// Motion that wheels and gyros do not see, as large as the options state: white noise whose
/// integral is the random walk of the pose.
inline TrueDrive::TwistFunction unseen_motion(double length, uint64_t seed,
                                              const OdometryOptions& options) {
  constexpr double kStep = 0.02;  // s
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0, 1 / std::sqrt(kStep));
  std::vector<geometry::Vector6> noise(static_cast<size_t>(length / kStep) + 2);
  for (geometry::Vector6& at : noise) {
    for (int i = 0; i < 6; ++i) {
      at[i] = (i < 3 ? options.rotation_walk : options.translation_walk) * normal(random);
    }
  }
  return [noise = std::move(noise)](double t) {
    return noise[std::min(static_cast<size_t>(t / kStep), noise.size() - 1)];
  };
}

/// Errors of a simulated lidar odometry: white noise of each result, of which the information knows
/// a part, and a drift in proportion to distance that changes slowly.
struct LidarErrors {
  double rotation_noise = 3e-4, translation_noise = 0.005;  // rad, m
  OdometryOptions unknown;  // the noise that is not in the information, and the drift
};

/// Sensors of a true drive with noise of known size, from a seed.
class SimulatedSensors {
 public:
  SimulatedSensors(const TrueDrive& drive, uint64_t seed, const LidarErrors& lidar = {})
      : drive_(drive), random_(seed), lidar_(lidar) {
    for (int i = 0; i < 6; ++i) drift_[i] = drift_sigma(i) * normal_(random_);
  }

  WheelOdometry wheels(double t, double scale = 1, double yaw_bias = 0) {
    WheelOdometry sample = drive_.wheels(t);
    for (double& v : sample.wheel_speed) v = v / scale + options_.wheel_noise * normal_(random_);
    sample.yaw_rate += yaw_bias + options_.yaw_rate_noise * normal_(random_);
    return sample;
  }

  ImuSample gyro(double t, const Eigen::Vector3d& bias) {
    ImuSample sample;
    sample.stamp = seconds(t);
    for (int i = 0; i < 3; ++i) {
      sample.angular_velocity[static_cast<size_t>(i)] =
          drive_.twist(t)[i] + bias[i] + 0.003 * normal_(random_);
    }
    sample.linear_acceleration.fill(std::nan(""));
    return sample;
  }

  /// Position in metres from a point at 48° north; course from the true velocity.
  GnssFix gnss(double t) {
    constexpr double kEarthRadius = 6.371e6, kLatitude = 0.84;
    const Eigen::Isometry3d T = drive_.pose(t);
    const Eigen::Vector3d ahead = T.linear().col(0);
    GnssFix fix;
    fix.stamp = seconds(t);
    fix.latitude = kLatitude + (T.translation().y() + normal_(random_)) / kEarthRadius;
    fix.longitude =
        0.2 + (T.translation().x() + normal_(random_)) / (kEarthRadius * std::cos(kLatitude));
    fix.altitude = fix.hdop = std::nan("");
    fix.speed = std::abs(drive_.twist(t)[3] + 0.1 * normal_(random_));
    fix.course = std::numbers::pi / 2 - std::atan2(ahead.y(), ahead.x()) + 0.01 * normal_(random_);
    fix.valid = true;
    return fix;
  }

  /// Motion between two times; `free_along` takes all information from the direction of travel.
  RelativePose lidar(double from, double to, bool free_along = false) {
    const Eigen::Isometry3d truth = drive_.pose(from).inverse() * drive_.pose(to);
    const double distance = truth.translation().norm();
    const double decay =
        std::exp(-(to - from) / to_seconds(lidar_.unknown.lidar_drift_time_constant));
    geometry::Vector6 error;
    RelativePose pose;
    for (int i = 0; i < 6; ++i) {
      drift_[i] =
          decay * drift_[i] + drift_sigma(i) * std::sqrt(1 - decay * decay) * normal_(random_);
      const double noise = i < 3 ? lidar_.rotation_noise : lidar_.translation_noise;
      const double unknown =
          i < 3 ? lidar_.unknown.lidar_rotation_noise : lidar_.unknown.lidar_translation_noise;
      error[i] = std::hypot(noise, unknown) * normal_(random_) + drift_[i] * distance;
      pose.information(i, i) = 1 / (noise * noise);
    }
    if (free_along) {
      pose.information(3, 3) = 0;
      error[3] -= 0.8 * truth.translation().x();  // as a registration that stays at its guess
    }
    pose.from = seconds(from);
    pose.to = seconds(to);
    pose.T_from_to = geometry::exp(error) * truth;
    return pose;
  }

 private:
  double drift_sigma(int i) const {
    return i < 3 ? lidar_.unknown.lidar_rotation_drift : lidar_.unknown.lidar_translation_drift;
  }

  const TrueDrive& drive_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  OdometryOptions options_;
  LidarErrors lidar_;
  geometry::Vector6 drift_;
};

/// Passes the sweep from `from` to `to` to the filter, as the daemon does.
inline void add_sweep(OdometryFilter& filter, double to, const RelativePose* pose) {
  filter.mark(seconds(to), true);
  filter.process_until(seconds(to));
  if (pose != nullptr) filter.add(*pose);
}

}  // namespace infuse::motion
