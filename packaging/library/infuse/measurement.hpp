#pragma once

/// @file
/// What sensors measure: `Stamp`, `Sweep`, `CameraFrame`, `WheelOdometry`, `ImuSample`, `GnssFix`,
/// `Rig`; `Result` and `Error`.

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/gyro_readings.hpp"
#include "drivers/measurement/rig.hpp"
#include "drivers/measurement/stamp.hpp"
#include "drivers/measurement/sweep.hpp"
#include "drivers/measurement/vehicle_samples.hpp"
#include "infuse/layout.hpp"
