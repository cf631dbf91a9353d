#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/host/file_descriptor.hpp"
#include "drivers/host/hardware_stamps.hpp"
#include "drivers/host/message_batch.hpp"
#include "drivers/measurement/datagram.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::lidar {

/// Local address on which datagrams are received, or interface that is tapped.
struct UdpOptions {
  std::string address;    ///< local IPv4 address; empty: any
  uint16_t port = 2368;   ///< 0 selects a free one
  std::string multicast;  ///< IPv4 group to join; empty: none
  std::string interface;  ///< interface on which the group is joined; empty: the kernel chooses
  bool tap = false;       ///< receive all that `interface` sees, whatever its address
  /// Bytes; 100 ms of a VLS-128 with two returns are 1810 datagrams of 2304 bytes in the kernel.
  size_t receive_buffer = size_t{8} << 20;
  /// IPv4 addresses, host byte order, whose datagrams the kernel passes on, of others one in 256,
  /// so that a flood displaces nothing; empty: all.
  std::vector<uint32_t> senders{};

  /// Returns what is wrong, or nothing.
  std::optional<std::string> invalid() const;
};

/// A UDP port that receives lidar packets, by a UDP socket or a tap.
class UdpSource {
 public:
  /// Opens the port. Errors: the address is not local (yet), the port is in use, no such interface.
  static Result<UdpSource> open(const UdpOptions& options, const host::TimeBase& base);

  /// Readable when a datagram is pending.
  int descriptor() const { return socket_.get(); }

  /// Reads pending datagrams, at most `batch.capacity()`, and calls `on(const Datagram&)` for each.
  /// Returns their number; if it equals the capacity, more may be pending.
  template <class OnDatagram>
  Result<size_t> read(host::MessageBatch& batch, OnDatagram on) {
    was_full_ |= is_full();
    const int count = batch.receive(socket_.get(), stamps_);
    if (count < 0) return read_error();
    if (batch.dropped() != 0) count_dropped(batch.dropped());
    for (size_t i = 0; i < static_cast<size_t>(count); ++i) on(datagram(batch[i]));
    return static_cast<size_t>(count);
  }

  /// Number of datagrams that the kernel has dropped at this socket, as far as known: a drop is
  /// reported with the next datagram that fits. With `filters_senders()` those that the filter has
  /// rejected since then are among them, but only where the buffer was full too.
  uint64_t dropped() const { return dropped_; }

  /// True if the kernel rejects datagrams of other senders.
  bool filters_senders() const { return !options_.senders.empty(); }

  /// Bytes of receive buffer that were requested, and granted.
  size_t buffer_requested() const { return options_.receive_buffer; }
  size_t buffer_granted() const { return granted_; }

  /// True if the last datagram has its stamp from the interface (its driver makes such stamps, and
  /// PTP's daemon has turned them on); false if from the kernel.
  bool stamped_by_hardware() const { return hardware_stamps_.stamped_by_hardware(); }

  /// The local port.
  uint16_t port() const { return options_.port; }

  /// Joins the multicast group again, since its interface may have been recreated. Does nothing
  /// without a group.
  void rejoin();

 private:
  UdpSource(const UdpOptions& options, const host::TimeBase& base)
      : options_(options), stamps_(base) {}
  Result<void> set_up();
  Result<void> prepare();
  Result<void> filter_senders();
  Result<void> join();
  bool is_full() const;
  void count_dropped(uint32_t by_kernel);
  Datagram datagram(const host::MessageBatch::Message& message);
  tl::unexpected<Error> read_error() const;
  std::string name() const;

  UdpOptions options_;
  host::WallStamps stamps_;
  host::HardwareStamps hardware_stamps_;
  host::FileDescriptor socket_;
  size_t granted_ = 0;
  uint64_t dropped_ = 0;
  uint32_t seen_drops_ = 0;  ///< the kernel's counter: of datagrams that do not fit or are rejected
  bool was_full_ = false;    ///< the buffer, since that counter was last seen to grow
};

}  // namespace infuse::lidar
