#pragma once

#include <netinet/in.h>
#include <sys/socket.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/receive/time_base.hpp"

namespace infuse::receive {

/// Room for the messages that one `recvmmsg` brings. Several sockets may use one in turn.
class MessageBatch {
 public:
  /// For up to `messages` at a time, each of up to `bytes`.
  MessageBatch(size_t messages, size_t bytes);
  MessageBatch(const MessageBatch&) = delete;
  MessageBatch& operator=(const MessageBatch&) = delete;

  /// One message as it was received; valid until the next `receive`.
  struct Message {
    Stamp stamp;                     ///< when the kernel had it; when it was read, where unknown
    std::span<const uint8_t> bytes;  ///< cut to the room there is
    const sockaddr_in& sender;       ///< of UDP
    bool truncated = false;          ///< it was longer than the room
    int64_t hardware_ns = 0;         ///< by the interface's own clock; 0: it does not say
  };

  /// Takes what waits at a socket, without waiting: how many messages. 0 with errno EAGAIN where
  /// nothing waits; an error of the socket is −1 with its errno.
  int receive(int socket, WallStamps& stamps);

  /// The message `i` of the last `receive`.
  Message operator[](size_t i) const;

  size_t capacity() const { return headers_.size(); }

  /// What the kernel has dropped at the last socket read since that was made, as far as the
  /// messages of the last `receive` tell; 0 where they tell nothing.
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
  std::vector<int64_t> hardware_ns_;
  uint32_t dropped_ = 0;
};

/// What the kernel says beside a message, in its control messages.
struct AncillaryData {
  int64_t wall_ns = 0;      ///< when the kernel had it; 0: not told
  int64_t hardware_ns = 0;  ///< when the interface had it, by a clock of its own; 0: not told
  uint32_t dropped = 0;     ///< at this socket since it was made; 0: not told

  /// Reads them; `header` as `recvmmsg` leaves it.
  static AncillaryData parse(const msghdr& header);
};

/// Asks that messages be stamped by the interface's own clock too, where it has one. What an
/// interface stamps is its driver's and the system's matter and is left as it is.
void request_hardware_stamps(int socket);

/// Asks the kernel to stamp and to count drops, and for a receive buffer of `wanted` bytes. Gives
/// the bytes granted, of payload and bookkeeping: less than requested where net.core.rmem_max
/// allows no more. `where` names the socket in errors.
Result<size_t> prepare_socket(int socket, size_t wanted, const std::string& where);

}  // namespace infuse::receive
