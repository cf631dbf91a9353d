#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/camera/v4l2_options.hpp"
#include "drivers/recording/drive.hpp"
#include "drivers/velodyne/udp_source.hpp"

namespace infuse::daemon {

/// A lidar that the daemon listens to: one `[[lidar]]` table.
struct LidarOptions {
  std::string name = "lidar";
  std::string model;              ///< "HDL-32E", ...; empty: inferred, in a replay only
  uint16_t port = 2368;           ///< UDP port of its data packets
  uint16_t position_port = 8308;  ///< and of its position packets
  std::string sender;             ///< IPv4 address it sends from; empty: any
  std::string address;            ///< of this host, that it is listened to on; empty: any
  std::string multicast;          ///< group that it sends to; empty: none
  std::string interface;          ///< on which that group is joined; empty: the kernel chooses
  size_t receive_buffer = velodyne::UdpOptions{}.receive_buffer;  ///< bytes
  std::string calibration;       ///< file of this unit; empty: the model's own table
  double cut_azimuth_deg = 180;  ///< where a sweep ends, clockwise from the front

  /// What is wrong, or nothing.
  std::optional<std::string> invalid() const;

  bool operator==(const LidarOptions&) const = default;

  /// How one of its ports is listened to.
  velodyne::UdpOptions udp(uint16_t at_port) const {
    return {address, at_port, multicast, interface, receive_buffer};
  }
};

/// A camera of this host: one `[[camera]]` table.
struct CameraOptions {
  std::string name = "camera";
  camera::V4l2Options stream;

  /// What is wrong, or nothing.
  std::optional<std::string> invalid() const;

  bool operator==(const CameraOptions&) const = default;
};

/// A CAN bus of this host: one `[[can]]` table.
struct BusOptions {
  std::string name = "can";
  std::string interface = "can0";
  std::string dbc;                            ///< names its signals; empty: frames are only counted
  std::optional<double> reverse_gear;         ///< value of `gear` in which wheel speeds count
                                              ///< backward; nothing: they carry their sign
  std::vector<recording::CanSignal> signals;  ///< each quantity at most once

  /// What is wrong, or nothing.
  std::optional<std::string> invalid() const;

  bool operator==(const BusOptions&) const = default;
};

/// A satellite receiver that sends NMEA sentences: the `[gnss]` table.
struct GnssOptions {
  std::string device;    ///< serial; empty: none
  std::string lidar;     ///< or the lidar that it is connected to, whose position packets repeat it
  uint32_t baud = 9600;  ///< bits a second

  /// What is wrong, or nothing.
  std::optional<std::string> invalid() const;

  bool operator==(const GnssOptions&) const = default;
};

}  // namespace infuse::daemon
