#pragma once

#include <array>
#include <cstdint>

#include "tests/fusion/motion/simulated_sensors.hpp"

namespace infuse::study {

/// What goes wrong in a drive.
enum Fault : int { kNothing, kSlip, kLock, kFastGnss, kTurnedGnss, kTunnel, kWrongLidar, kFaults };
inline constexpr std::array<const char*, kFaults> kFaultNames = {
    "none", "slip", "lock", "fast gnss", "turned gnss", "tunnel", "wrong lidar"};

/// What is drawn of a drive.
struct DrawnDrive {
  uint64_t seed;
  bool wheels, bus, gyro, gnss, lidar;
  double turns, slopes, speed, stops;             ///< rad/s, rad/s, m/s, m/s
  double scale, bus_bias, gyro_bias, gyro_delay;  ///< 1, rad/s, rad/s, s
  double gnss_interval, gnss_delay, lidar_noise;  ///< s, s, 1
  Fault fault = kNothing;
  double since, until, size;  ///< s, s, of the fault: its own unit

  explicit DrawnDrive(uint64_t seed_of_drive);

  /// True if the drive has the source that goes wrong.
  bool concerns(Fault which) const;
  /// True if this is wrong at `t` s.
  bool is_wrong(Fault which, double t) const { return fault == which && t > since && t < until; }
};

/// Its true motion, for `seconds`; `unseen` is a part that neither wheels nor gyros measure.
motion::TrueDrive true_drive(const DrawnDrive& drawn, double seconds,
                             motion::TrueDrive::TwistFunction unseen = {});

/// Sources that are used.
struct Used {
  bool wheels, bus, gyro, gnss, lidar;
};

/// Drives with some of the sources, by the settings of the daemon for such sensors.
geometry::Trajectory drive_by(const Used& used, const DrawnDrive& drawn,
                              const motion::TrueDrive& drive);

}  // namespace infuse::study
