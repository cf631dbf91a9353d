#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "daemon/protocol/reports.hpp"
#include "daemon/setup/port_setup.hpp"
#include "daemon/setup/sensor_id.hpp"
#include "daemon/setup/vehicle_setup.hpp"
#include "drivers/camera/image_decoder.hpp"
#include "drivers/camera/v4l2_options.hpp"
#include "drivers/lidar/lidar_decoder.hpp"
#include "drivers/measurement/rig.hpp"
#include "drivers/recording/drive_source.hpp"
#include "drivers/vehicle/serial_line_source.hpp"

namespace infuse::daemon {

/// A lidar, and how its packets are decoded.
struct LidarSetup {
  Device device;
  bool has_packets = true;  ///< false: the drive has decoded sweeps
  lidar::DecoderOptions decoder;
  Eigen::Isometry3d T_vehicle_lidar = Eigen::Isometry3d::Identity();  ///< for its inertial samples
};

/// A camera.
struct CameraSetup {
  Device device;
  camera::ImageOptions image;  ///< how its image files are decoded
  camera::V4l2Options stream;  ///< live: its device
};

/// A sensor of a setup.
struct Sensor {
  SensorId id;
  Device device;
};

/// The sensors of this host or of a drive: what each of them is, where its data comes from and how
/// it is decoded.
struct SensorSetup {
  bool live = false;                 ///< sensors of this host; false: of a drive
  std::vector<LidarSetup> lidars;    ///< by LidarIndex; the same as those of `rig`
  std::vector<CameraSetup> cameras;  ///< by CameraIndex; those of `rig` come first
  VehicleSetup vehicle;
  /// Lidar whose position packets carry the NMEA sentences of `vehicle.gnss`; nothing if the
  /// receiver has a stream of its own.
  std::optional<LidarIndex> gnss_lidar;
  Rig rig;  ///< mounts of the sensors

  std::vector<PortSetup> ports;                       ///< live: of the lidars
  std::optional<vehicle::SerialOptions> gnss_serial;  ///< live: device of the GNSS receiver
  /// Live: valid settings that are probably mistakes. Of a capture: lidars that are left out.
  std::vector<Error> doubts;

  std::filesystem::path path;     ///< the drive or capture
  recording::DriveSource source;  ///< its events; sensors have the same indices there
  uint64_t capture_bytes = 0;     ///< of all its captures; 0 if there are none

  /// True if images of the camera are used; those of others are only counted.
  bool is_mounted(CameraIndex camera) const { return camera < rig.cameras.size(); }

  /// All sensors, in the order of the reports DEVICES and HEALTH.
  std::vector<Sensor> sensors() const;
};

}  // namespace infuse::daemon
