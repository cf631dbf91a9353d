#include "drivers/lcm/lcm_sender.hpp"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace infuse::lcm {
namespace {

constexpr uint32_t kShortMagic = 0x4C433032, kFragmentMagic = 0x4C433033;  // LC02, LC03
constexpr size_t kMaxDatagram = 65'507;                                    // of UDP over IPv4
constexpr size_t kShortHeader = 8, kFragmentHeader = 20;
constexpr size_t kMaxChannelName = 63;
constexpr size_t kMaxMessage = size_t{64} << 20;
constexpr int kSendBuffer = 4 << 20;

template <class Number>
void append(std::vector<uint8_t>& bytes, Number value) {
  for (size_t k = sizeof value; k-- > 0;) bytes.push_back(static_cast<uint8_t>(value >> (8 * k)));
}

}  // namespace

std::optional<std::string> SenderOptions::invalid() const {
  in_addr address{};
  if (inet_pton(AF_INET, group.c_str(), &address) != 1 || !IN_MULTICAST(ntohl(address.s_addr)))
    return "group must be an IPv4 multicast address between 224.0.0.0 and 239.255.255.255";
  if (!interface.empty() && inet_pton(AF_INET, interface.c_str(), &address) != 1)
    return "interface must be an IPv4 address of this host";
  if (port == 0) return "port must be between 1 and 65535";
  if (ttl < 0 || ttl > 255) return "ttl must be between 0 and 255";
  return std::nullopt;
}

Result<LcmSender> LcmSender::open(const SenderOptions& options) {
  const auto failed = [&](const char* what) {
    return fail(std::string(what) + ": " + std::strerror(errno), "LCM " + options.group);
  };
  if (const auto wrong = options.invalid()) return fail(*wrong, "LCM");
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(options.port);
  inet_pton(AF_INET, options.group.c_str(), &to.sin_addr);
  LcmSender sender(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0), to);
  if (sender.socket_ < 0) return failed("no socket");
  const auto ttl = static_cast<unsigned char>(options.ttl);
  if (::setsockopt(sender.socket_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl) != 0)
    return failed("ttl cannot be set");
  if (!options.interface.empty()) {
    in_addr interface {};
    inet_pton(AF_INET, options.interface.c_str(), &interface);
    if (::setsockopt(sender.socket_, IPPROTO_IP, IP_MULTICAST_IF, &interface, sizeof interface) !=
        0)
      return failed(("no interface has the address " + options.interface).c_str());
  }
  ::setsockopt(sender.socket_, SOL_SOCKET, SO_SNDBUF, &kSendBuffer, sizeof kSendBuffer);
  return sender;
}

LcmSender::LcmSender(LcmSender&& other) noexcept
    : socket_(std::exchange(other.socket_, -1)),
      to_(other.to_),
      number_(other.number_),
      head_(std::move(other.head_)) {}

LcmSender& LcmSender::operator=(LcmSender&& other) noexcept {
  std::swap(socket_, other.socket_);
  std::swap(to_, other.to_);
  std::swap(number_, other.number_);
  std::swap(head_, other.head_);
  return *this;
}

LcmSender::~LcmSender() {
  if (socket_ >= 0) ::close(socket_);
}

Result<void> LcmSender::send_datagram(std::span<const uint8_t> head,
                                      std::span<const uint8_t> body) const {
  std::array<iovec, 2> parts{iovec{const_cast<uint8_t*>(head.data()), head.size()},
                             iovec{const_cast<uint8_t*>(body.data()), body.size()}};
  msghdr message{};
  message.msg_name = const_cast<sockaddr_in*>(&to_);
  message.msg_namelen = sizeof to_;
  message.msg_iov = parts.data();
  message.msg_iovlen = parts.size();
  if (::sendmsg(socket_, &message, MSG_DONTWAIT | MSG_NOSIGNAL) >= 0) return {};
  return fail(std::string("cannot be sent: ") + std::strerror(errno), "LCM");
}

Result<void> LcmSender::send(const std::string& channel, std::span<const uint8_t> payload) {
  if (channel.empty() || channel.size() > kMaxChannelName)
    return fail("a channel must have 1 to 63 bytes", "LCM channel " + channel);
  if (payload.size() > kMaxMessage) return fail("a message is larger than 64 MiB", "LCM");
  const uint32_t number = number_++;
  const auto add_channel = [&] {
    head_.insert(head_.end(), channel.begin(), channel.end());
    head_.push_back(0);
  };
  head_.clear();
  if (kShortHeader + channel.size() + 1 + payload.size() <= kMaxDatagram) {
    append(head_, kShortMagic);
    append(head_, number);
    add_channel();
    return send_datagram(head_, payload);
  }
  // The first fragment has the channel's name before its part.
  constexpr size_t kRoom = kMaxDatagram - kFragmentHeader;
  const size_t first = kRoom - channel.size() - 1;
  const size_t fragments = 1 + (payload.size() - first + kRoom - 1) / kRoom;
  size_t offset = 0;
  for (size_t k = 0; k < fragments; ++k) {
    const size_t length = std::min(k == 0 ? first : kRoom, payload.size() - offset);
    head_.clear();
    append(head_, kFragmentMagic);
    append(head_, number);
    append(head_, static_cast<uint32_t>(payload.size()));
    append(head_, static_cast<uint32_t>(offset));
    append(head_, static_cast<uint16_t>(k));
    append(head_, static_cast<uint16_t>(fragments));
    if (k == 0) add_channel();
    if (auto sent = send_datagram(head_, payload.subspan(offset, length)); !sent) return sent;
    offset += length;
  }
  return {};
}

}  // namespace infuse::lcm
