#pragma once

#include <optional>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/recording/drive.hpp"
#include "drivers/vehicle/signal_map.hpp"

namespace infuse::daemon {

/// Which of the vehicle's own sensors a drive has, and how its bus is read.
struct VehicleSetup {
  std::optional<vehicle::VehicleDecoder> decoder;  ///< of the bus; none where there is no bus
  bool has_imu = false;                            ///< an inertial unit beside the bus
  bool has_gps = false;                            ///< a receiver beside the bus
  std::vector<Error> notes;                        ///< what the DBC file has that was left out

  /// Something says how the vehicle moves.
  bool has_odometry() const { return decoder.has_value() || has_imu; }
};

/// Reads what drive.toml names. Fails where the DBC cannot be read, or has no such signal.
Result<VehicleSetup> set_up_vehicle(const recording::Drive& drive);

}  // namespace infuse::daemon
