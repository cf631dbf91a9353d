#pragma once

#include <linux/filter.h>

#include <cstdint>
#include <span>
#include <vector>

namespace infuse::lidar {

/// A filter that the kernel applies to the datagrams of a socket before they take room in its
/// buffer (SO_ATTACH_FILTER, classic BPF).
class PacketFilter {
 public:
  /// Maximum number of senders: a jump spans 255 instructions.
  static constexpr size_t kMaxSenders = 64;
  /// One in so many datagrams of other senders passes at random, so that they can be named.
  static constexpr uint32_t kOthersPassed = 256;

  /// Rejects IPv4 packets that are not UDP datagrams to `port`, whole; what `tcpdump -d` shows for
  /// "udp dst port" without the link layer. For a packet socket (SOCK_DGRAM).
  void require_port(uint16_t port);

  /// Rejects what is not from one of `senders` (host byte order, at most `kMaxSenders`), all but
  /// one in `kOthersPassed`. `source_address`: where the packet has its source address.
  void require_sender(std::span<const uint32_t> senders, uint32_t source_address);

  /// Attaches the filter to a socket; false with errno if the kernel refuses it.
  bool attach(int socket) &&;

 private:
  std::vector<sock_filter> program_;
};

}  // namespace infuse::lidar
