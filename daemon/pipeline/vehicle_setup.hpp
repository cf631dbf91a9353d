#pragma once

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/recording/drive.hpp"
#include "drivers/vehicle/signal_map.hpp"

namespace infuse::daemon {

/// The vehicle's own sensors, and the decoders of its CAN buses.
struct VehicleSetup {
  /// By bus; nothing if its frames are only counted.
  std::vector<std::optional<vehicle::VehicleDecoder>> buses;
  bool has_speed = false;    ///< a speed source in addition to the buses
  bool has_imu = false;      ///< an IMU in addition to the buses
  bool has_gnss = false;     ///< a GNSS receiver in addition to the buses
  std::vector<Error> notes;  ///< entries of the DBC file that were ignored

  /// True if a bus, a speed sensor or an inertial unit measures the motion, many times a second.
  bool has_motion_sensor() const {
    return has_speed || has_imu ||
           std::any_of(buses.begin(), buses.end(), [](const auto& bus) { return bus.has_value(); });
  }

  /// True if there is a source of odometry.
  bool has_odometry() const { return has_motion_sensor() || has_gnss; }
};

/// Sets up the decoder of a CAN bus; nothing if no signals are configured. Paths are relative to
/// `folder`; `where` is for messages; ignored entries of the DBC file are added to `notes`. Errors:
/// the DBC file cannot be read, or lacks a signal.
Result<std::optional<vehicle::VehicleDecoder>> set_up_bus(const recording::CanFiles& can,
                                                          const std::filesystem::path& folder,
                                                          const std::string& where,
                                                          std::vector<Error>& notes);

/// Sets up the sensors that drive.toml names. Errors: as `set_up_bus`.
Result<VehicleSetup> set_up_vehicle(const recording::Drive& drive);

}  // namespace infuse::daemon
