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
  kIpv6,       ///< not decoded: Velodyne lidars send IPv4
  kNotUdp,     ///< ARP, TCP …
  kTruncated,  ///< captured with a short snapshot length
  kMalformed,  ///< contradictory lengths
};

/// Decodes captured frames: link layer, IPv4 (with reassembly of fragments), UDP. Checksums are not
/// verified. If IPv4's length exceeds the frame, UDP's is used where that fits: VeloView saves
/// position packets with the IPv4 length of data packets.
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
  int link_type_;
  FragmentTable table_;
  uint64_t fragments_ = 0;
};

}  // namespace infuse::recording
