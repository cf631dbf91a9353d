#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "drivers/measurement/stamp.hpp"

namespace infuse {

/// Motion as the vehicle's own sensors measure it at one moment. A quantity that is not measured at
/// this moment is NaN.
struct WheelOdometry {
  Stamp stamp;                          ///< of the measurement
  std::array<double, 4> wheel_speed{};  ///< m/s: front left, front right, rear left, rear right
  double yaw_rate = 0;                  ///< rad/s, counter-clockwise seen from above
  double steering_angle = 0;            ///< rad at the steering wheel, left positive
  /// m/s forward at the centre of the rear axle, from a source that is not a wheel.
  double speed = std::numeric_limits<double>::quiet_NaN();
};

/// One sample of an inertial measurement unit, in the vehicle's axes (x forward, y left, z up).
struct ImuSample {
  Stamp stamp;                                  ///< of the measurement
  std::array<double, 3> angular_velocity{};     ///< rad/s
  std::array<double, 3> linear_acceleration{};  ///< m/s², gravity included (at rest: z ≈ +9.81)
};

/// One fix of a GNSS receiver.
struct GnssFix {
  Stamp stamp;           ///< of the measurement
  double latitude = 0;   ///< rad, WGS 84
  double longitude = 0;  ///< rad
  /// Height above the ellipsoid or the sea, m, as the receiver reports it; NaN if unknown.
  double altitude = 0;
  double speed = 0;    ///< m/s over ground; NaN if unknown
  double course = 0;   ///< rad clockwise from north; NaN if unknown
  double hdop = 0;     ///< horizontal dilution of precision; NaN if unknown
  int64_t utc_ns = 0;  ///< time as the receiver reports it, ns since the Unix epoch; 0 if unknown
  bool valid = false;  ///< true if the receiver reports the fix as valid
};

}  // namespace infuse
