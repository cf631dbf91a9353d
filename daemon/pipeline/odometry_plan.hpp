#pragma once

#include "daemon/config/odometry_settings.hpp"
#include "daemon/setup/sensor_setup.hpp"

namespace infuse::daemon {

/// Fills in what the settings leave open, by what the sensors measure; `lidar` is the one that
/// measures the motion.
///
/// The lidar is used where it can be related to the other sensors: where its mounting is known, or
/// there are none. Roll, pitch and height are followed wherever three gyros or a lidar are there;
/// the bus alone knows a plane. Sensors that measure in the vehicle's axes know what is forward, a
/// lidar alone only by its mounting; without such sensors nothing is waited for.
OdometrySettings plan_odometry(OdometrySettings settings, const SensorSetup& setup,
                               size_t lidar = 0);

}  // namespace infuse::daemon
