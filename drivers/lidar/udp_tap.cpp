#include "drivers/lidar/udp_tap.hpp"

#include <linux/if_packet.h>
#include <net/ethernet.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <utility>

#include "drivers/host/system_error.hpp"
#include "drivers/lidar/packet_filter.hpp"

namespace infuse::lidar {
namespace {

constexpr size_t kMinIpv4Header = 20;
constexpr size_t kUdpHeader = 8;
constexpr uint32_t kSourceAddress = 12;

uint16_t read_u16_be(std::span<const uint8_t> bytes, size_t at) {
  return static_cast<uint16_t>(bytes[at] << 8 | bytes[at + 1]);
}

}  // namespace

Result<host::FileDescriptor> open_tap(const std::string& interface, uint16_t port,
                                      std::span<const uint32_t> senders) {
  const std::string where = "tap of " + interface;
  const unsigned index = if_nametoindex(interface.c_str());
  if (index == 0) return fail("no such interface", interface);
  // Protocol 0: nothing is received before the filter is attached.
  host::FileDescriptor tap(socket(AF_PACKET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!tap) {
    return host::fail_errno("cannot create a packet socket", where,
                            "it needs CAP_NET_RAW and AF_PACKET: see tap.conf of the package");
  }
  PacketFilter filter;
  filter.require_port(port);
  if (!senders.empty()) filter.require_sender(senders, kSourceAddress);
  if (!std::move(filter).attach(tap.get())) {
    return host::fail_errno("cannot attach a filter", where);
  }
  packet_mreq promiscuous{};
  promiscuous.mr_ifindex = static_cast<int>(index);
  promiscuous.mr_type = PACKET_MR_PROMISC;
  if (setsockopt(tap.get(), SOL_PACKET, PACKET_ADD_MEMBERSHIP, &promiscuous, sizeof(promiscuous)) !=
      0) {
    return host::fail_errno("cannot receive what is addressed to others", where);
  }
  sockaddr_ll local{};
  local.sll_family = AF_PACKET;
  local.sll_protocol = htons(ETH_P_IP);
  local.sll_ifindex = static_cast<int>(index);
  if (bind(tap.get(), reinterpret_cast<const sockaddr*>(&local), sizeof(local)) != 0) {
    return host::fail_errno("cannot bind", where);
  }
  return tap;
}

std::optional<Datagram> parse_tapped(std::span<const uint8_t> packet) {
  if (packet.size() < kMinIpv4Header || packet[0] >> 4 != 4 || packet[9] != IPPROTO_UDP) {
    return std::nullopt;
  }
  const size_t header = (packet[0] & 0x0Fu) * size_t{4};
  if (header < kMinIpv4Header || packet.size() < header + kUdpHeader) return std::nullopt;
  const std::span<const uint8_t> segment = packet.subspan(header);
  const size_t length = read_u16_be(segment, 4);
  if (length < kUdpHeader) return std::nullopt;
  Datagram datagram;
  datagram.sender = static_cast<uint32_t>(read_u16_be(packet, 12)) << 16 | read_u16_be(packet, 14);
  datagram.sender_port = read_u16_be(segment, 0);
  datagram.destination_port = read_u16_be(segment, 2);
  datagram.payload = segment.subspan(kUdpHeader, std::min(length, segment.size()) - kUdpHeader);
  return datagram;
}

}  // namespace infuse::lidar
