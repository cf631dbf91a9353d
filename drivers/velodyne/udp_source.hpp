#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "drivers/measurement/datagram.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/receive/file_descriptor.hpp"
#include "drivers/receive/message_batch.hpp"

namespace infuse::velodyne {

/// Where datagrams are listened for.
struct UdpOptions {
  std::string address;    ///< IPv4 address of this host; empty: any
  uint16_t port = 2368;   ///< 0 takes a free one
  std::string multicast;  ///< IPv4 group to join; empty: none
  std::string interface;  ///< that it is joined on; empty: the kernel chooses
  /// Bytes; 100 ms of a VLS-128 with two returns are 1810 datagrams of 2304 bytes in the kernel.
  size_t receive_buffer = size_t{8} << 20;

  /// What is wrong, or nothing.
  std::optional<std::string> invalid() const;
};

/// A UDP port that lidars send to.
class UdpSource {
 public:
  /// Most bytes of a datagram; a longer one is cut, and so malformed.
  static constexpr size_t kMaxDatagramBytes = 2048;

  /// Errors: the address is not this host's (yet), the port is in use, no such interface.
  static Result<UdpSource> open(const UdpOptions& options, const receive::TimeBase& base);

  /// Readable when something waits.
  int descriptor() const { return socket_.get(); }

  /// Takes what waits, at most `batch.capacity()` datagrams, and calls `on(const Datagram&)` for
  /// each. How many they were: as many as the batch holds means that there may be more.
  template <class OnDatagram>
  Result<size_t> read(receive::MessageBatch& batch, OnDatagram on) {
    const int count = batch.receive(socket_.get(), stamps_);
    if (count < 0) return read_error();
    if (batch.dropped() != 0) dropped_ = batch.dropped();
    for (size_t i = 0; i < static_cast<size_t>(count); ++i) on(datagram(batch[i]));
    return static_cast<size_t>(count);
  }

  /// Datagrams that the kernel has dropped at this socket, as far as is known: a drop is told with
  /// the next datagram that fits.
  uint64_t dropped() const { return dropped_; }

  /// Bytes of receive buffer that were requested, and granted.
  size_t buffer_requested() const { return options_.receive_buffer; }
  size_t buffer_granted() const { return granted_; }

  /// The port that is listened to.
  uint16_t port() const { return options_.port; }

  /// Joins the multicast group again: its interface may have been made anew. Nothing without one.
  void rejoin();

 private:
  UdpSource(const UdpOptions& options, const receive::TimeBase& base)
      : options_(options), stamps_(base) {}
  Result<void> set_up();
  Result<void> join();
  Datagram datagram(const receive::MessageBatch::Message& message) const;
  tl::unexpected<Error> read_error() const;
  std::string name() const;

  UdpOptions options_;
  receive::WallStamps stamps_;
  receive::FileDescriptor socket_;
  size_t granted_ = 0;
  uint64_t dropped_ = 0;
};

}  // namespace infuse::velodyne
