#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/rig.hpp"
#include "drivers/recording/turn.hpp"

namespace infuse::recording {

/// Files of one lidar: packets or decoded sweeps. Paths are relative to the drive.
struct LidarFiles {
  std::string packets;             ///< capture, may be shared by several lidars; empty: none
  std::string sweeps;              ///< folder of NNNNNN.bin or .pcd and times.csv; empty: none
  uint16_t port = 2368;            ///< UDP destination port of data packets
  uint16_t position_port = 8308;   ///< UDP destination port of position packets
  std::optional<uint32_t> sender;  ///< IPv4 address, host byte order; absent: any
  std::string calibration;         ///< beam table of this unit; empty: the model's default
  std::optional<Turn> turn;        ///< of sweeps: gives the returns their times
  bool deskewed = false;           ///< sweeps are deskewed already, to the middle of their turn
};

/// Files of one camera.
struct CameraFiles {
  std::string images;  ///< folder of NNNNNN.png or .jpg and times.csv
  std::optional<PixelFormat>
      mosaic;         ///< Bayer pattern, if the files are raw Bayer data stored as grey
  bool grey = false;  ///< decode the files as grey images
};

/// Mapping of a vehicle quantity to the CAN signal that carries it.
struct CanSignal {
  std::string quantity;  ///< one of `can_quantities()`
  std::string signal;    ///< "MESSAGE.SIGNAL", as the DBC file names them
  double scale = 1;      ///< multiplies the SI value; −1 for a signal of opposite sign
  std::string unit;      ///< replaces the unit in the DBC file; empty: the DBC file's

  bool operator==(const CanSignal&) const = default;  ///< of all members
};

/// Files of the vehicle's CAN bus.
struct CanFiles {
  std::string log;                     ///< candump log, as written by `candump -L`
  std::string dbc;                     ///< DBC file that defines the signals
  std::string interface;               ///< only frames of this interface are used; empty: all
  std::optional<double> reverse_gear;  ///< value of `gear` for which wheel speeds are negated
  std::vector<CanSignal> signals;      ///< each quantity at most once
};

/// Quantities that a CAN signal can be mapped to: wheel_speed_front_left, wheel_speed_front_right,
/// wheel_speed_rear_left, wheel_speed_rear_right, speed, yaw_rate, steering_angle,
/// steering_fraction, acceleration_forward, …_left, …_up, angular_velocity_forward, …_left, …_up,
/// gear.
const std::vector<std::string>& can_quantities();

/// Content of a drive.toml: the rig and the files of the drive. The format is documented in
/// drivers/recording/DRIVE.md.
struct DriveDescription {
  std::string name;                  ///< free text
  bool times_trusted = true;         ///< false: the stamps are synthetic (`times = "synthetic"`)
  Rig rig;                           ///< sensors and mountings
  std::vector<LidarFiles> lidars;    ///< one per entry of `rig.lidars`
  std::vector<CameraFiles> cameras;  ///< one per entry of `rig.cameras`
  std::optional<CanFiles> can;       ///< nothing: no bus
  std::string speed;                 ///< speed.csv; empty: none
  std::string imu;                   ///< imu.csv; empty: none
  Duration imu_delay{0};             ///< from its measurements to its stamps, subtracted
  Duration imu_delay_sigma{0};       ///< standard deviation of the same; 0: it was not measured
  std::string gnss;                  ///< gnss.csv; empty: none
  std::string gnss_lidar;   ///< lidar whose position packets carry the fixes instead; empty: none
  std::string map;          ///< OpenStreetMap XML; empty: none
  std::string truth_poses;  ///< T_map_vehicle, TUM format; used to score, never to estimate
  std::string truth_rig;    ///< the true rig; used to score, never to estimate

  /// Returns what is invalid, if anything: the rig, a path outside the drive, a lidar without data,
  /// two lidars whose packets cannot be distinguished.
  std::optional<std::string> invalid() const;
};

/// A recorded drive: a folder with a drive.toml.
struct Drive {
  std::filesystem::path folder;  ///< of drive.toml
  DriveDescription description;  ///< what drive.toml states

  /// Reads `folder`/drive.toml and checks that every file it names exists.
  static Result<Drive> open(const std::filesystem::path& folder);

  /// Returns a path of the description relative to the working directory instead of the drive.
  std::filesystem::path resolve(const std::string& relative) const { return folder / relative; }
};

/// Writes `folder`/drive.toml. Creates the folder if it does not exist.
Result<void> write_drive_toml(const std::filesystem::path& folder,
                              const DriveDescription& description);

}  // namespace infuse::recording
