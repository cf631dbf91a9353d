#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "drivers/host/file_descriptor.hpp"
#include "drivers/measurement/datagram.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::lidar {

/// Opens a socket that sees every IPv4 packet of an interface, whatever its address
/// (AF_PACKET, promiscuous); the kernel passes on only UDP datagrams to `port` that are not
/// fragmented, and of `senders` if there are any (`PacketFilter`). Errors: no such interface, no
/// permission (CAP_NET_RAW).
Result<host::FileDescriptor> open_tap(const std::string& interface, uint16_t port,
                                      std::span<const uint32_t> senders = {});

/// Parses an IPv4 packet with a UDP datagram as it comes from a tap: sender, ports and payload, of
/// which what lies beyond the bytes is missing. Nothing if there is no UDP header.
std::optional<Datagram> parse_tapped(std::span<const uint8_t> packet);

}  // namespace infuse::lidar
