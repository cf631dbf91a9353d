#include "drivers/recording/udp_decoder.hpp"

#include "drivers/measurement/big_endian.hpp"
#include "drivers/recording/link_layer.hpp"

namespace infuse::recording {
namespace {

using big_endian::read_u16;
using big_endian::read_u32;

constexpr size_t kIpv4HeaderBytes = 20;
constexpr size_t kUdpHeaderBytes = 8;
constexpr uint8_t kProtocolUdp = 17;

// `segment` begins with the UDP header.
FrameOutcome decode_udp(std::span<const uint8_t> segment, Datagram& datagram) {
  if (segment.size() < kUdpHeaderBytes) return FrameOutcome::kMalformed;
  const size_t length = read_u16(segment, 4);
  if (length < kUdpHeaderBytes || length > segment.size()) return FrameOutcome::kMalformed;
  datagram.sender_port = read_u16(segment, 0);
  datagram.destination_port = read_u16(segment, 2);
  datagram.payload = segment.subspan(kUdpHeaderBytes, length - kUdpHeaderBytes);
  return FrameOutcome::kDatagram;
}

}  // namespace

FrameOutcome UdpDecoder::decode(Stamp stamp, std::span<const uint8_t> frame, size_t wire_length,
                                Datagram& datagram) {
  const FrameOutcome too_short =
      frame.size() < wire_length ? FrameOutcome::kTruncated : FrameOutcome::kMalformed;
  datagram.stamp = stamp;
  const LinkPayload link = find_ip(link_type_, frame);
  switch (link.kind) {
    case LinkPayload::Kind::kIpv4:
      return decode_ipv4(link.packet, too_short, datagram);
    case LinkPayload::Kind::kIpv6:
      return decode_ipv6(link.packet, too_short, datagram);
    case LinkPayload::Kind::kTooShort:
      return too_short;
    case LinkPayload::Kind::kOther:
      break;
  }
  return FrameOutcome::kNotUdp;
}

FrameOutcome UdpDecoder::decode_ipv4(std::span<const uint8_t> packet, FrameOutcome too_short,
                                     Datagram& datagram) {
  if (packet.size() < kIpv4HeaderBytes) return too_short;
  if (packet[0] >> 4 != 4) return FrameOutcome::kMalformed;
  if (packet[9] != kProtocolUdp) return FrameOutcome::kNotUdp;
  const size_t header = (packet[0] & 0x0Fu) * 4u;
  const size_t total = read_u16(packet, 2);
  if (header < kIpv4HeaderBytes || total < header) return FrameOutcome::kMalformed;
  datagram.sender = read_u32(packet, 12);
  const uint16_t flags_and_offset = read_u16(packet, 6);
  const bool more = (flags_and_offset & 0x2000) != 0;
  const size_t offset = (flags_and_offset & 0x1FFFu) * 8u;
  const bool fragment = more || offset > 0;
  if (packet.size() < total) {
    const bool whole = !fragment && packet.size() > header &&
                       decode_udp(packet.subspan(header), datagram) == FrameOutcome::kDatagram;
    return whole ? FrameOutcome::kDatagram : too_short;
  }
  const std::span<const uint8_t> segment = packet.subspan(header, total - header);
  if (!fragment) return decode_udp(segment, datagram);
  return add_fragment({datagram.stamp, datagram.sender, read_u32(packet, 16), read_u16(packet, 4),
                       offset, more, segment},
                      datagram);
}

/// RFC 8200: the header, then extension headers, of which that of a fragment is the last.
FrameOutcome UdpDecoder::decode_ipv6(std::span<const uint8_t> packet, FrameOutcome too_short,
                                     Datagram& datagram) {
  constexpr size_t kHeaderBytes = 40, kFragmentBytes = 8;
  constexpr uint8_t kHopByHop = 0, kRouting = 43, kFragment = 44, kDestination = 60;
  if (packet.size() < kHeaderBytes) return too_short;
  if (packet[0] >> 4 != 6) return FrameOutcome::kMalformed;
  const size_t length = read_u16(packet, 4);
  datagram.sender = ipv6_label(read_u32(packet, 20));
  const uint32_t destination = ipv6_label(read_u32(packet, 36));
  uint8_t next = packet[6];
  if (packet.size() < kHeaderBytes + length) return too_short;
  std::span<const uint8_t> rest = packet.subspan(kHeaderBytes, length);
  while (next == kHopByHop || next == kRouting || next == kDestination) {
    const size_t bytes = rest.size() < 2 ? 0 : (rest[1] + 1u) * 8u;
    if (bytes == 0 || rest.size() < bytes) return FrameOutcome::kMalformed;
    next = rest[0];
    rest = rest.subspan(bytes);
  }
  if (next == kProtocolUdp) return decode_udp(rest, datagram);
  if (next != kFragment) return FrameOutcome::kIpv6;
  if (rest.size() < kFragmentBytes) return FrameOutcome::kMalformed;
  if (rest[0] != kProtocolUdp) return FrameOutcome::kIpv6;
  const uint16_t offset_and_flags = read_u16(rest, 2);
  return add_fragment(
      {datagram.stamp, datagram.sender, destination, read_u32(rest, 4), offset_and_flags & 0xFFF8u,
       (offset_and_flags & 1) != 0, rest.subspan(kFragmentBytes)},
      datagram);
}

FrameOutcome UdpDecoder::add_fragment(const IpFragment& fragment, Datagram& datagram) {
  ++fragments_;
  const std::span<const uint8_t> reassembled = table_.add(fragment);
  return reassembled.empty() ? FrameOutcome::kFragment : decode_udp(reassembled, datagram);
}

}  // namespace infuse::recording
