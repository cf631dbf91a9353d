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

/// Which of the vehicle's own sensors a drive has, and how its bus is read.
struct VehicleSetup {
  /// By bus; nothing where its frames are only counted.
  std::vector<std::optional<vehicle::VehicleDecoder>> buses;
  bool has_imu = false;      ///< an inertial unit beside the buses
  bool has_gnss = false;     ///< a receiver beside the buses
  std::vector<Error> notes;  ///< what the DBC file has that was left out

  /// Something says how the vehicle moves.
  bool has_odometry() const {
    return has_imu ||
           std::any_of(buses.begin(), buses.end(), [](const auto& bus) { return bus.has_value(); });
  }
};

/// A bus by the files and signals that are named for it, whose paths are relative to `folder`:
/// nothing where no signals are. `where` is for messages; what the DBC file has that was left out
/// is added to `notes`. Fails where the DBC cannot be read, or has no such signal.
Result<std::optional<vehicle::VehicleDecoder>> set_up_bus(const recording::CanFiles& can,
                                                          const std::filesystem::path& folder,
                                                          const std::string& where,
                                                          std::vector<Error>& notes);

/// Reads what drive.toml names. Fails where the DBC cannot be read, or has no such signal.
Result<VehicleSetup> set_up_vehicle(const recording::Drive& drive);

}  // namespace infuse::daemon
