#pragma once

#include <cstdint>
#include <span>

namespace infuse::recording {

/// Whether `find_ipv4` knows the link type (libpcap's DLT_ numbers): Ethernet, Linux cooked v1 and
/// v2, raw IP, BSD loopback.
bool is_supported_link_type(int link_type);

/// What a captured frame carries.
struct LinkPayload {
  enum class Kind {
    kIpv4,      ///< `packet` begins with an IPv4 header
    kOther,     ///< ARP, IPv6 …
    kTooShort,  ///< ends before that can be told
  };
  Kind kind = Kind::kOther;
  std::span<const uint8_t> packet;
};

/// Looks through the link layer of a frame, VLAN tags (802.1Q, 802.1ad, 0x9100) included, to the
/// IPv4 packet in it.
LinkPayload find_ipv4(int link_type, std::span<const uint8_t> frame);

}  // namespace infuse::recording
