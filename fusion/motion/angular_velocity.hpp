#pragma once

#include <array>

#include "drivers/measurement/stamp.hpp"

namespace infuse::motion {

/// Angular velocity in the vehicle's axes with its own accuracy; a component that is not measured
/// is NaN.
struct AngularVelocity {
  Stamp stamp;
  std::array<double, 3> value{};  ///< rad/s
  double noise = 0;               ///< rad/s, standard deviation of each
};

}  // namespace infuse::motion
