#pragma once

#include <netinet/in.h>
#include <sys/socket.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/host/time_base.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::host {

/// Buffers for the messages of one `recvmmsg`. Several sockets may use one batch in turn.
class MessageBatch {
 public:
  /// Allocates buffers for up to `messages` messages of up to `bytes` each.
  MessageBatch(size_t messages, size_t bytes);
  MessageBatch(const MessageBatch&) = delete;
  MessageBatch& operator=(const MessageBatch&) = delete;

  /// One received message; valid until the next `receive`.
  struct Message {
    Stamp stamp;                     ///< kernel receive time; time of reading if unknown
    std::span<const uint8_t> bytes;  ///< truncated to the buffer's size
    const sockaddr_in& sender;       ///< sender of a UDP datagram
    bool truncated = false;          ///< true if the message was longer than the buffer
    /// Hardware stamp, ns by the interface's own clock; 0 if there is none.
    int64_t hardware_ns = 0;
    uint32_t interface = 0;  ///< index of the interface that stamped it; 0 if unknown
  };

  /// Receives the pending messages of a socket without waiting and returns their number. 0 with
  /// errno EAGAIN if none is pending; −1 with the errno of a socket error.
  int receive(int socket, WallStamps& stamps);

  /// Message `i` of the last `receive`.
  Message operator[](size_t i) const;

  size_t capacity() const { return headers_.size(); }

  /// Number of messages that the kernel has dropped at the last socket read since that socket was
  /// created, as reported with the messages of the last `receive`; 0 if they do not report it.
  uint32_t dropped() const { return dropped_; }

 private:
  static constexpr size_t kControlBytes = 192;
  struct alignas(cmsghdr) Control {
    char bytes[kControlBytes];
  };

  void read_ancillary_data(size_t message, const WallStamps& stamps);

  size_t bytes_each_;
  std::vector<uint8_t> bytes_;
  std::vector<iovec> vectors_;
  std::vector<sockaddr_in> senders_;
  std::vector<Control> controls_;
  std::vector<mmsghdr> headers_;
  std::vector<Stamp> stamps_;
  struct HardwareStamp {
    int64_t ns = 0;
    uint32_t interface = 0;
  };
  std::vector<HardwareStamp> hardware_;
  uint32_t dropped_ = 0;
};

/// Control messages that the kernel attaches to a message.
struct AncillaryData {
  int64_t wall_ns = 0;      ///< kernel receive time, wall clock; 0 if absent
  int64_t hardware_ns = 0;  ///< receive time by the interface's own clock; 0 if absent
  uint32_t interface = 0;   ///< index of that interface; 0 if absent
  uint32_t dropped = 0;     ///< messages dropped at this socket since it was created; 0 if absent

  /// Parses `header` as `recvmmsg` leaves it.
  static AncillaryData parse(const msghdr& header);
};

/// Requests hardware stamps for received messages, if the interface makes them (SO_TIMESTAMPING),
/// with its index. Does not change the interface's own configuration: PTP's daemon turns them on.
void request_hardware_stamps(int socket);

/// Enables the kernel's receive stamps and drop counter, and requests a receive buffer of
/// `requested` bytes. Returns the bytes granted, payload and bookkeeping together: less than
/// requested if net.core.rmem_max is smaller. `where` names the socket in errors.
Result<size_t> prepare_socket(int socket, size_t requested, const std::string& where);

}  // namespace infuse::host
