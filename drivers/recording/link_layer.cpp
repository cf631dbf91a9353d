#include "drivers/recording/link_layer.hpp"

#include <pcap/dlt.h>

#include "drivers/measurement/big_endian.hpp"

namespace infuse::recording {
namespace {

using big_endian::read_u16;
using big_endian::read_u32;

constexpr uint16_t kEtherTypeIpv4 = 0x0800;
constexpr uint16_t kEtherTypeIpv6 = 0x86DD;

bool is_vlan_tag(uint16_t ether_type) {
  return ether_type == 0x8100 || ether_type == 0x88A8 || ether_type == 0x9100;
}

// Parses a header of `header` bytes with the EtherType at offset `type_at`, and VLAN tags after it.
LinkPayload parse_ether_type(std::span<const uint8_t> frame, size_t type_at, size_t header) {
  if (frame.size() < header) return {LinkPayload::Kind::kTooShort, {}};
  uint16_t type = read_u16(frame, type_at);
  while (is_vlan_tag(type)) {
    if (frame.size() < header + 4) return {LinkPayload::Kind::kTooShort, {}};
    type = read_u16(frame, header + 2);
    header += 4;
  }
  if (type == kEtherTypeIpv6) return {LinkPayload::Kind::kIpv6, frame.subspan(header)};
  if (type != kEtherTypeIpv4) return {};
  return {LinkPayload::Kind::kIpv4, frame.subspan(header)};
}

LinkPayload parse_raw_ip(std::span<const uint8_t> frame) {
  if (frame.empty()) return {LinkPayload::Kind::kTooShort, {}};
  if (frame[0] >> 4 == 6) return {LinkPayload::Kind::kIpv6, frame};
  if (frame[0] >> 4 != 4) return {};
  return {LinkPayload::Kind::kIpv4, frame};
}

// The address family has four bytes in either byte order; AF_INET is 2 on all systems, AF_INET6
// 10, 24, 28 or 30.
LinkPayload parse_bsd_loopback(std::span<const uint8_t> frame) {
  if (frame.size() < 4) return {LinkPayload::Kind::kTooShort, {}};
  const uint32_t stored = read_u32(frame, 0);
  const uint32_t family = stored < 0x10000 ? stored : stored >> 24;
  if (family == 2) return {LinkPayload::Kind::kIpv4, frame.subspan(4)};
  const bool six = family == 10 || family == 24 || family == 28 || family == 30;
  return six ? LinkPayload{LinkPayload::Kind::kIpv6, frame.subspan(4)} : LinkPayload();
}

}  // namespace

bool is_supported_link_type(int link_type) {
  switch (link_type) {
    case DLT_EN10MB:
    case DLT_LINUX_SLL:
    case DLT_LINUX_SLL2:
    case DLT_RAW:
    case DLT_IPV4:
    case DLT_IPV6:
    case DLT_NULL:
    case DLT_LOOP:
      return true;
    default:
      return false;
  }
}

LinkPayload find_ip(int link_type, std::span<const uint8_t> frame) {
  switch (link_type) {
    case DLT_EN10MB:
      return parse_ether_type(frame, 12, 14);
    case DLT_LINUX_SLL:
      return parse_ether_type(frame, 14, 16);
    case DLT_LINUX_SLL2:
      return parse_ether_type(frame, 0, 20);
    case DLT_RAW:
    case DLT_IPV4:
    case DLT_IPV6:
      return parse_raw_ip(frame);
    case DLT_NULL:
    case DLT_LOOP:
      return parse_bsd_loopback(frame);
    default:
      return {};
  }
}

}  // namespace infuse::recording
