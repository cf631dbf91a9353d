#include "daemon/setup/port_setup.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

#include "drivers/lidar/packet_filter.hpp"
#include "drivers/measurement/ipv4_address.hpp"

namespace infuse::daemon {
namespace {

bool same_socket(const lidar::UdpOptions& a, const lidar::UdpOptions& b) {
  return a.port == b.port && a.address == b.address && a.multicast == b.multicast &&
         a.interface == b.interface && a.tap == b.tap;
}

/// Two lidars that share a port must have different senders.
Result<void> check_senders(const std::vector<LidarOptions>& lidars) {
  for (size_t i = 0; i < lidars.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      const LidarOptions &a = lidars[j], &b = lidars[i];
      const bool apart = parse_address(a.sender) != parse_address(b.sender);
      if (apart || !same_socket(a.udp(a.port), b.udp(b.port))) continue;
      return fail(fmt::format("lidars '{}' and '{}' cannot be told apart on port {}", a.name,
                              b.name, b.port),
                  b.source, "give each its sender, or another port");
    }
  }
  return {};
}

void add_sender(const lidar::UdpOptions& udp, const PortSetup::Sender& sender,
                std::vector<PortSetup>& ports) {
  for (PortSetup& port : ports) {
    if (!same_socket(port.udp, udp)) continue;
    port.udp.receive_buffer = std::max(port.udp.receive_buffer, udp.receive_buffer);
    return port.senders.push_back(sender);
  }
  ports.push_back({udp, {sender}});
}

void filter_senders(PortSetup& port) {
  for (const PortSetup::Sender& sender : port.senders) {
    if (sender.address == 0) return;
  }
  if (port.senders.size() > lidar::PacketFilter::kMaxSenders) return;
  for (const PortSetup::Sender& sender : port.senders) port.udp.senders.push_back(sender.address);
}

}  // namespace

LidarIndex PortSetup::lidar_of(uint32_t sender) const {
  const Sender* any = nullptr;
  for (const Sender& known : senders) {
    if (known.address == sender) return known.lidar;
    if (known.address == 0) any = &known;
  }
  return any != nullptr ? any->lidar : senders.front().lidar;
}

Result<std::vector<PortSetup>> set_up_ports(const std::vector<LidarOptions>& lidars) {
  if (auto apart = check_senders(lidars); !apart) return tl::unexpected(apart.error());
  std::vector<PortSetup> ports;
  for (size_t i = 0; i < lidars.size(); ++i) {
    const LidarOptions& lidar = lidars[i];
    const uint32_t sender = parse_address(lidar.sender).value_or(0);
    add_sender(lidar.udp(lidar.port), {sender, LidarIndex(i), true}, ports);
    if (lidar.position_port == lidar.port) continue;
    add_sender(lidar.udp(lidar.position_port), {sender, LidarIndex(i), false}, ports);
  }
  for (PortSetup& port : ports) filter_senders(port);
  return ports;
}

}  // namespace infuse::daemon
