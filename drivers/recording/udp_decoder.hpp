#pragma once

#include <cstdint>
#include <span>

#include "drivers/measurement/datagram.hpp"
#include "drivers/recording/fragment_table.hpp"

namespace infuse::recording {

/// What became of one captured frame.
enum class FrameOutcome {
  kDatagram,   ///< a whole UDP datagram
  kFragment,   ///< a fragment of one that is not whole yet, or never will be
  kNotUdp,     ///< ARP, TCP, IPv6 …
  kTruncated,  ///< captured short
  kMalformed,  ///< lengths that contradict each other
};

/// Takes captured frames apart: link layer, IPv4 (fragments put together), UDP. Checksums are not
/// verified.
class UdpDecoder {
 public:
  /// `link_type` is libpcap's DLT_ number.
  UdpDecoder(int link_type, size_t fragmented_datagrams, Duration fragment_age)
      : link_type_(link_type), table_(fragmented_datagrams, fragment_age) {}

  /// Decodes a frame that was `wire_length` bytes long on the wire. On `kDatagram`, `datagram` is
  /// filled, its payload valid until the next call and as long as `frame`.
  FrameOutcome decode(Stamp stamp, std::span<const uint8_t> frame, size_t wire_length,
                      Datagram& datagram);

  /// Fragments seen, and of these such as never became whole.
  uint64_t fragments() const { return fragments_; }
  uint64_t fragments_dropped() const { return table_.dropped(); }

  /// Gives up incomplete datagrams. Call at the end of the stream.
  void finish() { table_.drop_all(); }

 private:
  int link_type_;
  FragmentTable table_;
  uint64_t fragments_ = 0;
};

}  // namespace infuse::recording
