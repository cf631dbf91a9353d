#pragma once

#include <cstdint>

#include "daemon/health/conditions.hpp"
#include "daemon/health/health_options.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// What the odometry filter says of itself, at one moment of drive time. Plain data.
struct OdometryStatus {
  const char* reason = "";       ///< static text: why it cannot be trusted; empty where it can
  double speed = 0;              ///< m/s along x
  double yaw_rate = 0;           ///< rad/s
  bool standing = false;         ///< the vehicle stands
  double wheel_scale = 1;        ///< true over measured speed
  double wheel_scale_sigma = 0;  ///< its standard deviation
  double yaw_rate_bias = 0;      ///< rad/s, of the vehicle's yaw-rate sensor
  double yaw_rate_bias_sigma = 0;
  double gyro_bias = 0;  ///< rad/s, of the inertial unit about z
  double gyro_bias_sigma = 0;
  uint64_t late = 0;             ///< samples that came after their time had been worked off
  uint64_t outliers = 0;         ///< samples that did not agree with the motion
  uint64_t invalid_samples = 0;  ///< samples without a finite quantity, or of a time of their own
  uint64_t not_deskewed = 0;     ///< sweeps passed on as they were measured

  bool usable() const { return *reason == '\0'; }
};

/// Judges whether odometry does its work. Pure.
class OdometryHealth {
 public:
  explicit OdometryHealth(const HealthOptions& options);

  /// About one call a second. The answer is valid until the
  /// next call.
  const Conditions& update(Stamp now, const OdometryStatus& figures);

 private:
  uint64_t not_deskewed_ = 0;
  Conditions conditions_;
};

}  // namespace infuse::daemon
