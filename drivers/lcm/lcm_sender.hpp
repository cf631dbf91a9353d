#pragma once

#include <netinet/in.h>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"

namespace infuse::lcm {

/// Where messages are sent to.
struct SenderOptions {
  std::string group = "239.255.76.67";  ///< IPv4 multicast group; the default of LCM
  uint16_t port = 7667;
  int ttl = 0;  ///< 0: this host only; 1: the local network
  std::string
      interface;  ///< IPv4 address of the interface to send from; empty: the system's choice

  std::optional<std::string> invalid() const;
};

/// Sends messages of LCM by UDP multicast: short ones in a datagram, others in fragments. Never
/// waits: where the socket is full, the rest of a message is dropped.
class LcmSender {
 public:
  static Result<LcmSender> open(const SenderOptions& options);
  LcmSender(LcmSender&& other) noexcept;
  LcmSender& operator=(LcmSender&& other) noexcept;
  ~LcmSender();

  /// Sends a message. Errors: a channel without a name or with more than 63 bytes, a message of
  /// more than 64 MiB, the network is unreachable, the socket is full.
  Result<void> send(const std::string& channel, std::span<const uint8_t> payload);

 private:
  LcmSender(int socket, const sockaddr_in& to) : socket_(socket), to_(to) {}
  Result<void> send_datagram(std::span<const uint8_t> head, std::span<const uint8_t> body) const;

  int socket_ = -1;
  sockaddr_in to_{};
  uint32_t number_ = 0;  // of the next message
  std::vector<uint8_t> head_;
};

}  // namespace infuse::lcm
