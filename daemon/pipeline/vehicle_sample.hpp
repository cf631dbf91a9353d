#pragma once

#include <variant>

#include "drivers/measurement/vehicle_samples.hpp"

namespace infuse::daemon {

/// Anything that the vehicle's own sensors say of its motion.
using VehicleSample = std::variant<WheelOdometry, ImuSample, GnssFix>;

}  // namespace infuse::daemon
