#pragma once

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/protocol/reports.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/recording/drive.hpp"
#include "drivers/vehicle/signal_map.hpp"
#include "drivers/vehicle/socket_can_source.hpp"

namespace infuse::daemon {

/// A CAN bus.
struct BusSetup {
  Device device;
  std::optional<vehicle::VehicleDecoder> decoder;  ///< nothing: its frames are only counted
  vehicle::SocketCanOptions interface;             ///< live
};

/// The vehicle's own sensors, and the decoders of its CAN buses.
struct VehicleSetup {
  std::vector<BusSetup> buses;  ///< by BusIndex
  std::optional<Device> speed;  ///< a speed source in addition to the buses
  std::optional<Device> imu;    ///< an IMU in addition to the buses
  double imu_delay_sigma = 0;   ///< s, of the delay that a drive states; 0: none
  std::optional<Device> gnss;   ///< a GNSS receiver in addition to the buses
  std::vector<Error> notes;     ///< entries of the DBC file that were ignored

  /// True if a bus, a speed sensor or an inertial unit measures the motion, many times a second.
  bool has_motion_sensor() const {
    return speed || imu || std::any_of(buses.begin(), buses.end(), [](const BusSetup& bus) {
             return bus.decoder.has_value();
           });
  }

  /// True if three gyros measure the rotation.
  bool has_gyros() const {
    return imu || std::any_of(buses.begin(), buses.end(), [](const BusSetup& bus) {
             return bus.decoder && bus.decoder->has_gyros();
           });
  }

  /// True if there is a source of odometry.
  bool has_odometry() const { return has_motion_sensor() || gnss; }
};

/// Makes the decoder of a CAN bus; nothing if no signals are configured. Paths are relative to
/// `folder`; `where` is for messages; ignored entries of the DBC file are added to `notes`. Errors:
/// the DBC file cannot be read, or lacks a signal.
Result<std::optional<vehicle::VehicleDecoder>> make_decoder(const recording::CanFiles& can,
                                                            const std::filesystem::path& folder,
                                                            const std::string& where,
                                                            std::vector<Error>& notes);

/// Sets up the sensors that drive.toml names, but for a GNSS receiver at a lidar. Errors: as
/// `make_decoder`.
Result<VehicleSetup> set_up_vehicle(const recording::Drive& drive);

}  // namespace infuse::daemon
