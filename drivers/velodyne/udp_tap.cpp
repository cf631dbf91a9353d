#include "drivers/velodyne/udp_tap.hpp"

#include <linux/filter.h>
#include <linux/if_packet.h>
#include <net/ethernet.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>

#include "drivers/receive/system_error.hpp"

namespace infuse::velodyne {
namespace {

constexpr size_t kMinIpv4Header = 20;
constexpr size_t kUdpHeader = 8;

uint16_t read_u16_be(std::span<const uint8_t> bytes, size_t at) {
  return static_cast<uint16_t>(bytes[at] << 8 | bytes[at + 1]);
}

/// Lets UDP datagrams to `port` pass; what `tcpdump -d` shows for "udp dst port" without the link
/// layer.
bool attach_port_filter(int socket, uint16_t port) {
  constexpr uint8_t kReject = 255;  // replaced by the distance to the last instruction
  std::array<sock_filter, 9> program = {{
      BPF_STMT(BPF_LD | BPF_B | BPF_ABS, 9),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, IPPROTO_UDP, 0, kReject),
      BPF_STMT(BPF_LD | BPF_H | BPF_ABS, 6),
      BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, 0x3FFF, kReject, 0),  // more fragments, offset
      BPF_STMT(BPF_LDX | BPF_B | BPF_MSH, 0),
      BPF_STMT(BPF_LD | BPF_H | BPF_IND, 2),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, port, 0, kReject),
      BPF_STMT(BPF_RET | BPF_K, 0xFFFF),
      BPF_STMT(BPF_RET | BPF_K, 0),
  }};
  for (size_t i = 0; i < program.size(); ++i) {
    const auto to_end = static_cast<uint8_t>(program.size() - 2 - i);
    if (program[i].jt == kReject) program[i].jt = to_end;
    if (program[i].jf == kReject) program[i].jf = to_end;
  }
  const sock_fprog filter{static_cast<unsigned short>(program.size()), program.data()};
  return setsockopt(socket, SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof(filter)) == 0;
}

}  // namespace

Result<receive::FileDescriptor> open_tap(const std::string& interface, uint16_t port) {
  const std::string where = "tap of " + interface;
  const unsigned index = if_nametoindex(interface.c_str());
  if (index == 0) return fail("no such interface", interface);
  // Protocol 0: nothing is received before the filter is attached.
  receive::FileDescriptor tap(socket(AF_PACKET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!tap) {
    return receive::fail_errno("cannot create a packet socket", where,
                               "it needs CAP_NET_RAW and AF_PACKET: see tap.conf of the package");
  }
  if (!attach_port_filter(tap.get(), port)) {
    return receive::fail_errno("cannot attach a filter", where);
  }
  packet_mreq promiscuous{};
  promiscuous.mr_ifindex = static_cast<int>(index);
  promiscuous.mr_type = PACKET_MR_PROMISC;
  if (setsockopt(tap.get(), SOL_PACKET, PACKET_ADD_MEMBERSHIP, &promiscuous, sizeof(promiscuous)) !=
      0) {
    return receive::fail_errno("cannot receive what is addressed to others", where);
  }
  sockaddr_ll local{};
  local.sll_family = AF_PACKET;
  local.sll_protocol = htons(ETH_P_IP);
  local.sll_ifindex = static_cast<int>(index);
  if (bind(tap.get(), reinterpret_cast<const sockaddr*>(&local), sizeof(local)) != 0) {
    return receive::fail_errno("cannot bind", where);
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

}  // namespace infuse::velodyne
