#pragma once

#include <cstdint>
#include <vector>

#include "daemon/config/config.hpp"
#include "daemon/setup/sensor_id.hpp"
#include "drivers/lidar/udp_source.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// A UDP port and the lidars that send to it.
struct PortSetup {
  struct Sender {
    uint32_t address = 0;  ///< IPv4, host byte order; 0: any
    LidarIndex lidar;
    bool data = true;  ///< false: this port receives the lidar's position packets
  };
  lidar::UdpOptions udp;
  std::vector<Sender> senders;

  /// Returns the lidar to which a datagram belongs: the one with this sender address, else one
  /// without a configured sender, else the first one, which rejects and counts the datagram as
  /// coming from an unexpected sender.
  LidarIndex lidar_of(uint32_t sender) const;
};

/// The ports of the configured lidars; where every lidar of a port has a sender, the kernel
/// filters. Errors: two lidars of one port cannot be told apart.
Result<std::vector<PortSetup>> set_up_ports(const std::vector<LidarOptions>& lidars);

}  // namespace infuse::daemon
