#pragma once

#include <array>
#include <cstdint>

#include "drivers/measurement/stamp.hpp"

namespace infuse {

/// What the vehicle's own sensors say of its motion at one moment. A quantity that this moment does
/// not tell is NaN.
struct WheelOdometry {
  Stamp stamp;
  std::array<double, 4> wheel_speed{};  ///< m/s: front left, front right, rear left, rear right
  double yaw_rate = 0;                  ///< rad/s, counter-clockwise seen from above
  double steering_angle = 0;            ///< rad at the steering wheel, left positive
};

/// One sample of an inertial unit, in the vehicle's axes (x forward, y left, z up).
struct ImuSample {
  Stamp stamp;
  std::array<double, 3> angular_velocity{};     ///< rad/s
  std::array<double, 3> linear_acceleration{};  ///< m/s², gravity included (standing: z ≈ +9.81)
};

/// One fix of a satellite receiver.
struct GnssFix {
  Stamp stamp;
  double latitude = 0;   ///< rad, WGS 84
  double longitude = 0;  ///< rad
  double altitude =
      0;  ///< m above the ellipsoid or the sea, as the receiver says; NaN where it does not
  double speed = 0;   ///< m/s over ground; NaN where unknown
  double course = 0;  ///< rad clockwise from north; NaN where unknown
  double hdop = 0;    ///< HDOP; NaN where unknown
  int64_t utc_ns =
      0;  ///< what the receiver says the time is, ns since the Unix epoch; 0 where unknown
  bool valid = false;  ///< the receiver itself calls the fix valid
};

}  // namespace infuse
