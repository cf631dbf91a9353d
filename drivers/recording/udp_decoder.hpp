#pragma once

#include <cstdint>
#include <span>

#include "drivers/measurement/datagram.hpp"
#include "drivers/recording/fragment_table.hpp"

namespace infuse::recording {

/// Result of decoding one captured frame.
enum class FrameOutcome {
  kDatagram,   ///< a complete UDP datagram
  kFragment,   ///< a fragment of an incomplete datagram
  kIpv6,       ///< IPv6, but not UDP
  kNotUdp,     ///< ARP, TCP …
  kTruncated,  ///< captured with a short snapshot length
  kMalformed,  ///< contradictory lengths
};

/// Stands for an IPv6 host where an IPv4 address is expected: an address of the class that nobody
/// has (240.0.0.0 and up), with the last 28 bits of the host's.
constexpr uint32_t ipv6_label(uint32_t last_four_bytes) {
  return 0xF000'0000 | (last_four_bytes & 0x0FFF'FFFF);
}

/// Decodes captured frames: link layer, IPv4 and IPv6 (with reassembly of fragments), UDP. An IPv6
/// sender is named by `ipv6_label`. Checksums are not verified. If IPv4's length exceeds the frame,
/// UDP's is used where that fits: VeloView saves position packets with the IPv4 length of data
/// packets.
class UdpDecoder {
 public:
  /// `link_type` is libpcap's DLT_ number.
  UdpDecoder(int link_type, size_t fragmented_datagrams, Duration fragment_timeout)
      : link_type_(link_type), table_(fragmented_datagrams, fragment_timeout) {}

  /// Decodes a frame that was `wire_length` bytes long on the wire. On `kDatagram`, `datagram` is
  /// filled, its payload valid until the next call and as long as `frame`.
  FrameOutcome decode(Stamp stamp, std::span<const uint8_t> frame, size_t wire_length,
                      Datagram& datagram);

  /// Number of fragments seen.
  uint64_t fragments() const { return fragments_; }
  /// Number of fragments of datagrams that were never complete.
  uint64_t fragments_dropped() const { return table_.dropped(); }

  /// Drops incomplete datagrams. Call at the end of the stream.
  void finish() { table_.drop_all(); }

 private:
  FrameOutcome decode_ipv4(std::span<const uint8_t> packet, FrameOutcome too_short,
                           Datagram& datagram);
  FrameOutcome decode_ipv6(std::span<const uint8_t> packet, FrameOutcome too_short,
                           Datagram& datagram);
  FrameOutcome add_fragment(const IpFragment& fragment, Datagram& datagram);

  int link_type_;
  FragmentTable table_;
  uint64_t fragments_ = 0;
};

}  // namespace infuse::recording
