#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "daemon/health/alert_checks.hpp"
#include "daemon/health/health_options.hpp"
#include "drivers/measurement/stamp.hpp"
#include "fusion/motion/odometry_sources.hpp"

namespace infuse::daemon {

/// One source of odometry. Plain data.
struct OdometrySourceStatus {
  const char* name = "";  ///< one of `motion::kOdometrySourceNames`
  bool carries = false;   ///< the odometry uses it now
  uint64_t accepted = 0;  ///< samples that were used
  uint64_t rejected = 0;  ///< samples rejected as inconsistent with the others
};
using OdometrySourceStatuses = std::array<OdometrySourceStatus, motion::kOdometrySources>;

/// Status of the odometry filter at one moment of drive time. Plain data.
struct OdometryStatus {
  bool present = false;     ///< there is a source of odometry
  const char* reason = "";  ///< static text: why it is not usable; empty if it is
  OdometrySourceStatuses sources;
  double speed_sigma = 0;        ///< m/s, standard deviation of `speed`
  double yaw_rate_sigma = 0;     ///< rad/s, standard deviation of `yaw_rate`
  double speed = 0;              ///< m/s along x
  double yaw_rate = 0;           ///< rad/s
  bool standing = false;         ///< true if the vehicle stands still
  double wheel_scale = 1;        ///< true over measured speed
  double wheel_scale_sigma = 0;  ///< its standard deviation
  double yaw_rate_bias = 0;      ///< rad/s, of the vehicle's yaw-rate sensor
  double yaw_rate_bias_sigma = 0;
  double gyro_bias = 0;  ///< rad/s, of the inertial unit about z
  double gyro_bias_sigma = 0;
  /// s from measurement to stamp, beyond what the configuration states; sigma 0: no such source.
  double yaw_rate_delay = 0, yaw_rate_delay_sigma = 0;
  double imu_delay = 0, imu_delay_sigma = 0;
  double gnss_delay = 0, gnss_delay_sigma = 0;
  double steering_ratio = 0;  ///< steering wheel angle over road wheel angle
  const char* wanted = "";    ///< static text: what would bound the largest uncertainty, or empty
  uint64_t late = 0;          ///< samples that arrived after their time had been processed
  uint64_t outliers = 0;      ///< samples rejected as inconsistent with the motion
  uint64_t invalid_samples = 0;  ///< samples without a finite quantity, or with an implausible time
  uint64_t not_deskewed = 0;     ///< sweeps passed on as measured

  bool usable() const { return *reason == '\0'; }
};

/// What the alerts of odometry are checked by, at one update.
struct OdometryTick {
  const OdometryStatus& status;
  const std::string& contradicting;  ///< names of the sources that contradict the motion
  uint64_t not_deskewed;             ///< sweeps passed on as measured since the last update
};

/// The alerts of odometry, the worst first.
std::span<const Alert<OdometryTick>> odometry_alerts();

/// Checks odometry. Pure.
class OdometryHealth {
 public:
  explicit OdometryHealth(const HealthOptions& options);

  /// Updates the findings; called about once a second. The result is valid until the next call.
  const AlertChecks<OdometryTick>& update(Stamp now, const OdometryStatus& status);

 private:
  /// Whether a source errs as its sigmas say.
  struct Verdict {
    double evidence = 0;  // log of a ratio of likelihoods; 0: it errs as stated
    bool contradicts = false;
    Stamp last = Stamp::earliest();  // when it did
  };
  std::string contradicting(Stamp now, const OdometrySourceStatuses& sources);

  uint64_t not_deskewed_ = 0;
  Duration raise_after_;
  OdometrySourceStatuses before_;  // at the last update
  std::array<Verdict, motion::kOdometrySources> verdicts_;
  AlertChecks<OdometryTick> checks_;
};

}  // namespace infuse::daemon
