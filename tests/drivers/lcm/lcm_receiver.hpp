#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <bit>
#include <cstring>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/lcm/lcm_sender.hpp"

namespace infuse::lcm {

/// Fingerprints that lcm-gen 1.3.1 makes of drivers/lcm/infuse.lcm: its constants, rotated left by
/// one bit as its code does.
inline constexpr uint64_t kPoseFingerprint = std::rotl(uint64_t{0x52006c7f88ee8add}, 1);
inline constexpr uint64_t kSweepFingerprint = std::rotl(uint64_t{0x8442f62b32ddab2a}, 1);
inline constexpr uint64_t kAlertFingerprint = std::rotl(uint64_t{0x79f06279e641d396}, 1);

/// Reads members of a message one by one. Beyond the end everything is zero.
class LcmFields {
 public:
  explicit LcmFields(std::span<const uint8_t> bytes) : rest_(bytes) {}
  template <class Number>
  Number number() {
    std::array<uint8_t, sizeof(Number)> bytes{};
    if (rest_.size() < bytes.size()) return Number{};
    std::copy_n(rest_.begin(), bytes.size(), bytes.rbegin());
    rest_ = rest_.subspan(bytes.size());
    return std::bit_cast<Number>(bytes);
  }
  std::string text() {
    const auto length = static_cast<size_t>(number<int32_t>());
    if (length == 0 || length > rest_.size() || rest_[length - 1] != 0) return "no text";
    const std::string value(rest_.begin(), rest_.begin() + static_cast<std::ptrdiff_t>(length - 1));
    rest_ = rest_.subspan(length);
    return value;
  }
  bool at_end() const { return rest_.empty(); }

 private:
  std::span<const uint8_t> rest_;
};

/// A message as received.
struct ReceivedMessage {
  std::string channel;
  std::vector<uint8_t> payload;
  uint32_t number = 0;
  size_t datagrams = 0;
};

/// Receives messages by the documents of LCM's UDP multicast protocol, on the loopback only.
class LcmReceiver {
 public:
  LcmReceiver() {
    socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_ANY);
    socklen_t length = sizeof address;
    ip_mreq group{};
    inet_pton(AF_INET, options_.group.c_str(), &group.imr_multiaddr);
    group.imr_interface.s_addr = htonl(INADDR_LOOPBACK);
    const int buffer = 8 << 20;
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &buffer, sizeof buffer);
    works_ = ::bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0 &&
             ::getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &length) == 0 &&
             ::setsockopt(socket_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group) == 0;
    options_.port = ntohs(address.sin_port);
    options_.interface = "127.0.0.1";
    if (!works_) return;
    // Some hosts have no multicast on the loopback: see with a datagram that is no message.
    auto sender = LcmSender::open(options_);
    works_ = sender && sender->send("x", {}) && next().has_value();
  }
  ~LcmReceiver() { ::close(socket_); }
  LcmReceiver(const LcmReceiver&) = delete;
  LcmReceiver& operator=(const LcmReceiver&) = delete;

  bool works() const { return works_; }
  SenderOptions options() const { return options_; }

  /// The next whole message; nothing if none comes.
  std::optional<ReceivedMessage> next() {
    std::vector<uint8_t> bytes(65'536);
    while (true) {
      pollfd ready{socket_, POLLIN, 0};
      if (::poll(&ready, 1, 2000) != 1) return std::nullopt;
      const ssize_t size = ::recv(socket_, bytes.data(), bytes.size(), 0);
      if (size < 8) return std::nullopt;
      const std::span datagram(bytes.data(), static_cast<size_t>(size));
      LcmFields fields(datagram);
      const auto magic = fields.number<uint32_t>();
      const auto number = fields.number<uint32_t>();
      if (magic == 0x4c433032) return short_message(number, datagram.subspan(8));
      if (magic != 0x4c433033) return std::nullopt;
      if (auto whole = add_fragment(number, datagram)) return whole;
    }
  }

 private:
  static ReceivedMessage short_message(uint32_t number, std::span<const uint8_t> rest) {
    const auto end = std::ranges::find(rest, uint8_t{0});
    return {{rest.begin(), end}, {end + 1, rest.end()}, number, 1};
  }
  std::optional<ReceivedMessage> add_fragment(uint32_t number, std::span<const uint8_t> datagram) {
    LcmFields fields(datagram.subspan(8));
    const auto size = fields.number<uint32_t>();
    const auto offset = fields.number<uint32_t>();
    const auto fragment = fields.number<uint16_t>();
    const auto fragments = fields.number<uint16_t>();
    auto part = datagram.subspan(20);
    ReceivedMessage& message = partial_[number];
    message.number = number;
    message.payload.resize(size);
    if (fragment == 0) {
      const auto end = std::ranges::find(part, uint8_t{0});
      message.channel.assign(part.begin(), end);
      part = part.subspan(message.channel.size() + 1);
    }
    if (offset + part.size() > size) return std::nullopt;
    std::ranges::copy(part, message.payload.begin() + offset);
    if (++message.datagrams < fragments) return std::nullopt;
    auto whole = std::move(message);
    partial_.erase(number);
    return whole;
  }

  int socket_ = -1;
  bool works_ = false;
  SenderOptions options_;
  std::map<uint32_t, ReceivedMessage> partial_;
};

}  // namespace infuse::lcm
