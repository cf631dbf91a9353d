#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/camera/v4l2_options.hpp"
#include "drivers/lidar/udp_source.hpp"
#include "drivers/recording/drive.hpp"

namespace infuse::daemon {

/// A lidar: one `[[lidar]]` table.
struct LidarOptions {
  std::string name = "lidar";
  std::string source;             ///< file and line of its table
  std::string model;              ///< "HDL-32E", ...; empty: inferred, in a replay only
  uint16_t port = 2368;           ///< UDP port of its data packets
  uint16_t position_port = 8308;  ///< UDP port of its position packets
  std::string sender;             ///< IPv4 source address; empty: any
  std::string address;            ///< local IPv4 address; empty: any
  std::string multicast;          ///< multicast group; empty: none
  std::string interface;          ///< interface that joins the group; empty: chosen by the kernel
  bool tap = false;               ///< receive all that the interface sees, whatever its address
  size_t receive_buffer = lidar::UdpOptions{}.receive_buffer;  ///< bytes
  std::string calibration;       ///< calibration file of this unit; empty: the model's table
  double cut_azimuth_deg = 180;  ///< azimuth at which a sweep ends, clockwise from the front

  /// Returns what is wrong with the options, or nothing.
  std::optional<std::string> invalid() const;

  bool operator==(const LidarOptions&) const = default;

  /// Returns the options of the socket for one of its ports.
  lidar::UdpOptions udp(uint16_t at_port) const {
    return {address, at_port, multicast, interface, tap, receive_buffer, {}};
  }
};

/// A camera of this host: one `[[camera]]` table.
struct CameraOptions {
  std::string name = "camera";
  std::string source;  ///< file and line of its table
  camera::V4l2Options stream;

  /// Returns what is wrong with the options, or nothing.
  std::optional<std::string> invalid() const;

  bool operator==(const CameraOptions&) const = default;
};

/// A CAN bus of this host: one `[[can]]` table.
struct BusOptions {
  std::string name = "can";
  std::string source;  ///< file and line of its table
  std::string interface = "can0";
  std::string dbc;                     ///< DBC file of its signals; empty: frames are only counted
  std::optional<double> reverse_gear;  ///< value of `gear` with which wheel speeds are negative;
                                       ///< nothing: wheel speeds are signed
  std::vector<recording::CanSignal> signals;  ///< each quantity at most once

  /// Returns what is wrong with the options, or nothing.
  std::optional<std::string> invalid() const;

  bool operator==(const BusOptions&) const = default;
};

/// A GNSS receiver that sends NMEA sentences: the `[gnss]` table.
struct GnssOptions {
  std::string device;    ///< serial device; empty: none
  std::string lidar;     ///< lidar whose position packets carry the sentences; empty: none
  uint32_t baud = 9600;  ///< bit/s

  /// Returns what is wrong with the options, or nothing.
  std::optional<std::string> invalid() const;

  bool operator==(const GnssOptions&) const = default;
};

}  // namespace infuse::daemon
