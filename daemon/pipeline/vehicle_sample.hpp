#pragma once

#include <variant>

#include "drivers/measurement/gyro_readings.hpp"
#include "drivers/measurement/vehicle_samples.hpp"

namespace infuse::daemon {

/// A measurement of the vehicle's motion.
using VehicleSample = std::variant<WheelOdometry, ImuSample, GnssFix, GyroReadings>;

}  // namespace infuse::daemon
