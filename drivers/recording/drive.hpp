#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/rig.hpp"

namespace infuse::recording {

/// Where a lidar's data lies: packets or decoded sweeps. Paths are relative to the drive.
struct LidarFiles {
  std::string packets;             ///< capture; several lidars may share one. Empty: none
  std::string sweeps;              ///< folder of NNNNNN.bin or .pcd and times.csv. Empty: none
  uint16_t port = 2368;            ///< UDP destination port of its data packets
  uint16_t position_port = 8308;   ///< of its position packets
  std::optional<uint32_t> sender;  ///< IPv4 address, host byte order; absent: any
  std::string calibration;         ///< the unit's own beam table; empty: the model's
};

/// Where a camera's pictures lie.
struct CameraFiles {
  std::string images;                 ///< folder of NNNNNN.png or .jpg and times.csv
  std::optional<PixelFormat> mosaic;  ///< the pictures are grey files of a Bayer sensor
  bool grey = false;                  ///< the files' colour is left out when they are read
};

/// Which CAN signal tells a quantity of the vehicle.
struct CanSignal {
  std::string quantity;  ///< one of `can_quantities()`
  std::string signal;    ///< "MESSAGE.SIGNAL", as the DBC file names them
  double scale = 1;      ///< multiplies the SI value; −1 where the bus counts the other way
  std::string unit;      ///< where the DBC's is missing or wrong; empty: the DBC's

  bool operator==(const CanSignal&) const = default;
};

/// The vehicle's bus.
struct CanFiles {
  std::string log;                     ///< as `candump -L` writes it
  std::string dbc;                     ///< names its signals
  std::string interface;               ///< frames of others are passed over; empty: all
  std::optional<double> reverse_gear;  ///< value of `gear` in which wheel speeds count backward
  std::vector<CanSignal> signals;      ///< each quantity at most once
};

/// Quantities that a CAN signal can be mapped to: wheel_speed_front_left, wheel_speed_front_right,
/// wheel_speed_rear_left, wheel_speed_rear_right, yaw_rate, steering_angle, steering_fraction,
/// acceleration_forward, …_left, …_up, angular_velocity_forward, …_left, …_up, gear.
const std::vector<std::string>& can_quantities();

/// What drive.toml says: the rig, and which file holds what. drivers/recording/DRIVE.md is its
/// manual.
struct DriveDescription {
  std::string name;           ///< free text
  bool times_trusted = true;  ///< false: the stamps are synthetic (`times = "synthetic"`)
  Rig rig;
  std::vector<LidarFiles> lidars;    ///< an entry for each of `rig.lidars`
  std::vector<CameraFiles> cameras;  ///< an entry for each of `rig.cameras`
  std::optional<CanFiles> can;
  std::string imu;          ///< imu.csv; empty: none
  std::string gnss;         ///< gnss.csv; empty: none
  std::string gnss_lidar;   ///< lidar whose position packets carry the fixes instead; empty: none
  std::string map;          ///< OpenStreetMap XML; empty: none
  std::string truth_poses;  ///< T_map_vehicle, TUM format; used to score, never to estimate
  std::string truth_rig;    ///< the true rig; used to score, never to estimate

  /// What is wrong, or nothing: the rig, a path that leaves the drive, a lidar without data, two
  /// lidars that cannot be told apart.
  std::optional<std::string> invalid() const;
};

/// A recorded drive: a folder with a drive.toml.
struct Drive {
  std::filesystem::path folder;
  DriveDescription description;

  /// Reads `folder`/drive.toml and looks whether every file that it names exists.
  static Result<Drive> open(const std::filesystem::path& folder);

  /// A path of the description, made usable from outside the drive.
  std::filesystem::path resolve(const std::string& relative) const { return folder / relative; }
};

/// Writes `folder`/drive.toml, making the folder where it is missing.
Result<void> write_drive_toml(const std::filesystem::path& folder,
                              const DriveDescription& description);

}  // namespace infuse::recording
