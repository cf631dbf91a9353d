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

/// A UDP port and the lidars that send to it.
struct PortSetup {
  struct Sender {
    uint32_t address = 0;  ///< IPv4, host byte order; 0: any
    size_t lidar = 0;
    bool data = true;  ///< false: this port receives the lidar's position packets
  };
  lidar::UdpOptions udp;
  std::vector<Sender> senders;

  /// Returns the lidar to which a datagram belongs: the one with this sender address, else one
  /// without a configured sender, else the first one, which rejects and counts the datagram as
  /// coming from an unexpected sender.
  size_t lidar_of(uint32_t sender) const;
};

/// Configuration of the live sources, in addition to what the pipeline needs. Indices are those of
/// the devices.
struct LiveSetup : PipelineSetup {
  std::vector<PortSetup> ports;
  std::vector<camera::V4l2Options> camera_streams;
  std::vector<vehicle::SocketCanOptions> interfaces;  ///< of the CAN buses
  std::optional<vehicle::SerialOptions> gnss;
  std::vector<Error>
      doubts;  ///< what is valid and yet hardly meant, such as a camera without a mount
};

/// Sets up the sensors of the configuration. Lidars that are not in the rig are mounted at the
/// vehicle's origin; cameras that are not in the rig are only counted. Errors: a lidar without a
/// model, a rig or DBC file that cannot be read, an image size that differs from the rig's.
Result<LiveSetup> set_up_live(const Config& config);

}  // namespace infuse::daemon
