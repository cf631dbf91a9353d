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
  const LinkPayload link = find_ipv4(link_type_, frame);
  if (link.kind == LinkPayload::Kind::kTooShort) return too_short;
  if (link.kind == LinkPayload::Kind::kIpv6) return FrameOutcome::kIpv6;
  if (link.kind == LinkPayload::Kind::kOther) return FrameOutcome::kNotUdp;

  const std::span<const uint8_t> packet = link.packet;
  if (packet.size() < kIpv4HeaderBytes) return too_short;
  if (packet[0] >> 4 != 4) return FrameOutcome::kMalformed;
  if (packet[9] != kProtocolUdp) return FrameOutcome::kNotUdp;
  const size_t header = (packet[0] & 0x0Fu) * 4u;
  const size_t total = read_u16(packet, 2);
  if (header < kIpv4HeaderBytes || total < header) return FrameOutcome::kMalformed;
  datagram.stamp = stamp;
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

  ++fragments_;
  const std::span<const uint8_t> reassembled = table_.add(
      {stamp, datagram.sender, read_u32(packet, 16), read_u16(packet, 4), offset, more, segment});
  return reassembled.empty() ? FrameOutcome::kFragment : decode_udp(reassembled, datagram);
}

}  // namespace infuse::recording
