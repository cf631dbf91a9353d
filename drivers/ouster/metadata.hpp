#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/ouster/profile.hpp"

namespace infuse::ouster {

/// Maximum number of beams of a sensor.
inline constexpr size_t kMaxBeams = 128;
/// Maximum number of columns in a turn.
inline constexpr uint16_t kMaxColumnsPerTurn = 4096;
/// Maximum number of columns in a packet.
inline constexpr uint16_t kMaxColumnsPerPacket = 16;

/// What the sensor's clock follows (`timestamp_mode`).
enum class TimeMode : uint8_t {
  kUnknown,   ///< the metadata does not say
  kInternal,  ///< TIME_FROM_INTERNAL_OSC: counts from power-up
  kPps,       ///< TIME_FROM_SYNC_PULSE_IN: pulse per second, with the time of an NMEA sentence
  kPtp,       ///< TIME_FROM_PTP_1588: a PTP master's time
};

/// Description of a time mode for people: "PTP", "internal oscillator".
const char* describe(TimeMode mode);

/// Which of a pulse's returns comes first in a pixel, or is the only one (`return_order`).
enum class FirstReturn : uint8_t { kStrongest, kFarthest, kNearest };

/// The columns of a turn that the sensor sends: from `first` to `last`, inclusive; across the
/// turn's beginning if `first` is larger.
struct ColumnWindow {
  uint16_t first = 0;
  uint16_t last = 0;
};

/// A sensor's description of itself, without which its packets cannot be read: as it gives it at
/// `GET /api/v1/sensor/metadata`, and as recorders store it beside a capture.
struct Metadata {
  std::string text;          ///< the JSON itself
  std::string product_line;  ///< "OS-1-64"; empty if not stated
  std::string serial_number;
  std::string firmware;  ///< "v2.3.0"; empty if not stated
  Profile profile = Profile::kLegacy;
  bool fusa_header = false;         ///< headers have the layout for functional safety
  bool has_other_imu = false;       ///< inertial packets are of a profile that is not read
  uint16_t columns_per_turn = 0;    ///< 512, 1024, 2048 or 4096
  uint16_t columns_per_packet = 0;  ///< 16 unless configured
  ColumnWindow window;
  double turns_per_second = 0;  ///< 0 if not stated
  TimeMode time_mode = TimeMode::kUnknown;
  FirstReturn first_return = FirstReturn::kStrongest;
  uint16_t lidar_port = 7502;
  uint16_t imu_port = 7503;

  /// Elevation and azimuth offset of each beam, rad, in the order of the wire (from above). The
  /// offset turns clockwise, as the sensor does.
  std::vector<double> elevation, azimuth;
  Eigen::Isometry3d T_lidar_beam{Eigen::Isometry3d::Identity()};    ///< m; a beam's origin
  Eigen::Isometry3d T_sensor_lidar{Eigen::Isometry3d::Identity()};  ///< m
  Eigen::Isometry3d T_sensor_imu{Eigen::Isometry3d::Identity()};    ///< m

  /// Number of beams.
  size_t beams() const { return elevation.size(); }
  /// The beams that exist, from below, as indices of `elevation`. Firmware before 1.14 describes
  /// 64, of which a sensor may have 16 or 32; the others have no angles.
  std::vector<size_t> beams_from_below() const;
  /// Azimuth, rad, counter-clockwise from the sensor's front, at which its turn begins: π, but for
  /// sensors that are calibrated otherwise.
  double begin_azimuth() const;
  /// Number of columns in the window.
  uint16_t window_columns() const {
    return static_cast<uint16_t>(window.first <= window.last
                                     ? window.last - window.first + 1
                                     : columns_per_turn - window.first + window.last + 1);
  }
  /// Model as people write it: "OS1-64", "OSDome-128"; the product line where it is neither.
  std::string model() const;
};

/// Parses metadata in both layouts: all keys on the top level (firmware before 3.0), or in
/// `sensor_info`, `beam_intrinsics`, `lidar_data_format` and others. What old firmware leaves out
/// has its default: the radius of the beams' origins by product line, 16 columns a packet, and the
/// whole turn as window. Errors: no JSON, more than 1 MiB, nested deeper than 16, a missing or
/// impossible number, another profile.
Result<Metadata> parse_metadata(std::string_view text, const std::string& where);

/// Parses a file.
Result<Metadata> load_metadata(const std::filesystem::path& path);

}  // namespace infuse::ouster
