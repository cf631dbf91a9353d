#pragma once

#include <cstdint>
#include <span>

namespace infuse::recording {

/// True if `find_ip` supports the link type (libpcap's DLT_ numbers): Ethernet, Linux cooked v1
/// and v2, raw IP, BSD loopback.
bool is_supported_link_type(int link_type);

/// Network-layer packet of a captured frame.
struct LinkPayload {
  enum class Kind {
    kIpv4,      ///< `packet` begins with an IPv4 header
    kIpv6,      ///< … with an IPv6 header
    kOther,     ///< ARP …
    kTooShort,  ///< the frame ends within its link-layer header
  };
  Kind kind = Kind::kOther;
  std::span<const uint8_t> packet;
};

/// Finds the IP packet in a frame: skips the link-layer header and VLAN tags (802.1Q, 802.1ad,
/// 0x9100).
LinkPayload find_ip(int link_type, std::span<const uint8_t> frame);

}  // namespace infuse::recording
