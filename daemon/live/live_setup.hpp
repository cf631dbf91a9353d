#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/config/config.hpp"
#include "daemon/pipeline/pipeline_setup.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/vehicle/serial_line_source.hpp"
#include "drivers/vehicle/socket_can_source.hpp"

namespace infuse::daemon {

/// A UDP port, and the lidars that send to it.
struct PortSetup {
  struct Sender {
    uint32_t address = 0;  ///< IPv4, host byte order; 0: any
    size_t lidar = 0;
    bool data = true;  ///< false: its position packets come here
  };
  velodyne::UdpOptions udp;
  std::vector<Sender> senders;

  /// Whose a datagram is: the lidar's that sends from there, else that of one that may send from
  /// anywhere, else the first's, which refuses it and counts it.
  size_t lidar_of(uint32_t sender) const;
  /// Whether what comes from there is that lidar's.
  bool is_from_lidar(size_t lidar, uint32_t sender) const;
};

/// What is read live, and what the pipeline is told of it. Indices are those of the devices.
struct LiveSetup : PipelineSetup {
  std::vector<PortSetup> ports;
  std::vector<camera::V4l2Options> camera_streams;
  std::vector<vehicle::SocketCanOptions> interfaces;  ///< of the buses
  std::optional<vehicle::SerialOptions> gnss;
  std::optional<size_t> gnss_lidar;  ///< whose position packets have the receiver's sentences
};

/// Sets up what the configuration names. Sensors that the rig does not have are mounted at the
/// vehicle's origin (lidars) or only counted (cameras). Errors: no model of a lidar, a rig or DBC
/// that cannot be read, a picture size that is not the rig's.
Result<LiveSetup> set_up_live(const Config& config);

}  // namespace infuse::daemon
