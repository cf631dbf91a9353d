#pragma once

#include <array>

#include "drivers/measurement/stamp.hpp"

namespace infuse {

/// Readings of the three gyros in a lidar's housing. Which axis each measures, and with which sign
/// and bias, is not known (`motion::GyroAxes`).
struct GyroReadings {
  Stamp stamp;                   ///< of the readings
  std::array<double, 3> rate{};  ///< rad/s
};

}  // namespace infuse
