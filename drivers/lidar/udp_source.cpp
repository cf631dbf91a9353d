#include "drivers/lidar/udp_source.hpp"

#include <arpa/inet.h>
#include <linux/sock_diag.h>
#include <net/if.h>

#include <array>
#include <utility>

#include "drivers/host/system_error.hpp"
#include "drivers/lidar/packet_filter.hpp"
#include "drivers/lidar/udp_tap.hpp"
#include "drivers/measurement/ipv4_address.hpp"

namespace infuse::lidar {
namespace {

constexpr size_t kMaxReceiveBuffer = size_t{1} << 30;  // bytes

std::optional<in_addr> parse_ipv4(const std::string& text) {
  if (text.empty()) return in_addr{INADDR_ANY};
  const auto address = parse_address(text);
  if (!address) return std::nullopt;
  return in_addr{htonl(*address)};
}

}  // namespace

std::optional<std::string> UdpOptions::invalid() const {
  if (!parse_ipv4(address)) return "'" + address + "' is not an IPv4 address";
  const auto group = parse_ipv4(multicast);
  if (!multicast.empty() && !(group && IN_MULTICAST(ntohl(group->s_addr)))) {
    return "'" + multicast + "' is not an IPv4 multicast group";
  }
  if (interface.size() >= IF_NAMESIZE) return "'" + interface + "' is not an interface name";
  if (tap && interface.empty()) return "a tap needs an interface";
  if (tap && !(address.empty() && multicast.empty())) {
    return "a tap has neither an address nor a multicast group";
  }
  if (tap && port == 0) return "a tap needs a port";
  if (senders.size() > PacketFilter::kMaxSenders) return "too many senders";
  if (receive_buffer == 0 || receive_buffer > kMaxReceiveBuffer) {
    return "the receive buffer size must lie in 1 byte ... 1 GiB";
  }
  return std::nullopt;
}

Result<UdpSource> UdpSource::open(const UdpOptions& options, const host::TimeBase& base) {
  UdpSource source(options, base);
  if (auto wrong = options.invalid()) return fail(*wrong, source.name());
  if (const auto ready = source.set_up(); !ready) return tl::unexpected(ready.error());
  return source;
}

/// Stamps, drop counter and buffer of the socket.
Result<void> UdpSource::prepare() {
  const auto granted = host::prepare_socket(socket_.get(), options_.receive_buffer, name());
  if (!granted) return tl::unexpected(granted.error());
  granted_ = *granted;
  host::request_hardware_stamps(socket_.get());
  return {};
}

/// Attached before the socket is bound: nothing arrives without it.
Result<void> UdpSource::filter_senders() {
  if (options_.senders.empty()) return {};
  constexpr auto kSourceInDatagram = static_cast<uint32_t>(SKF_NET_OFF + 12);
  PacketFilter filter;
  filter.require_sender(options_.senders, kSourceInDatagram);
  if (std::move(filter).attach(socket_.get())) return {};
  return host::fail_errno("cannot attach a filter", name());
}

Result<void> UdpSource::set_up() {
  if (options_.tap) {
    auto tap = open_tap(options_.interface, options_.port, options_.senders);
    if (!tap) return tl::unexpected(tap.error());
    socket_ = *std::move(tap);
    return prepare();
  }
  socket_ = host::FileDescriptor(socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket_) return host::fail_errno("cannot create a socket", name());
  if (auto prepared = prepare(); !prepared) return prepared;
  if (auto filtered = filter_senders(); !filtered) return filtered;
  if (!options_.multicast.empty()) {  // several processes may receive from a group
    const int on = 1;
    setsockopt(socket_.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
  }
  sockaddr_in local{};
  local.sin_family = AF_INET;
  local.sin_port = htons(options_.port);
  local.sin_addr = *parse_ipv4(options_.address);
  if (bind(socket_.get(), reinterpret_cast<const sockaddr*>(&local), sizeof(local)) != 0) {
    return host::fail_errno("cannot bind", name(),
                            errno == EADDRINUSE ? "the port is in use by another program" : "");
  }
  socklen_t size = sizeof(local);
  getsockname(socket_.get(), reinterpret_cast<sockaddr*>(&local), &size);
  options_.port = ntohs(local.sin_port);
  return join();
}

Result<void> UdpSource::join() {
  if (options_.multicast.empty()) return {};
  ip_mreqn request{};
  request.imr_multiaddr = *parse_ipv4(options_.multicast);
  if (!options_.interface.empty()) {
    request.imr_ifindex = static_cast<int>(if_nametoindex(options_.interface.c_str()));
    if (request.imr_ifindex == 0) return fail("no such interface", options_.interface);
  }
  if (setsockopt(socket_.get(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &request, sizeof(request)) != 0 &&
      errno != EADDRINUSE) {  // EADDRINUSE means that it is a member already
    return host::fail_errno("cannot join the group " + options_.multicast + "", name(),
                            "set the lidar's interface");
  }
  return {};
}

/// True if datagrams may have been dropped since the last read because the buffer was full: nobody
/// else empties it, and a datagram is smaller than half of it.
bool UdpSource::is_full() const {
  if (!filters_senders()) return true;  // all drops are for want of room
  std::array<uint32_t, SK_MEMINFO_VARS> memory{};
  socklen_t size = sizeof(memory);
  if (getsockopt(socket_.get(), SOL_SOCKET, SO_MEMINFO, memory.data(), &size) != 0) return true;
  return memory[SK_MEMINFO_RMEM_ALLOC] >= memory[SK_MEMINFO_RCVBUF] / 2;
}

/// The kernel counts what its filter rejects with what does not fit.
void UdpSource::count_dropped(uint32_t by_kernel) {
  const uint32_t more = by_kernel - std::exchange(seen_drops_, by_kernel);
  if (more == 0) return;
  if (was_full_) dropped_ += more;
  was_full_ = false;
}

void UdpSource::rejoin() { static_cast<void>(join()); }

Datagram UdpSource::datagram(const host::MessageBatch::Message& message) {
  const Stamp stamp =
      hardware_stamps_.update(message.hardware_ns, message.stamp, message.interface);
  if (options_.tap) {
    // Without a UDP header, which the filter asks for: an empty datagram, which is malformed.
    Datagram tapped = parse_tapped(message.bytes).value_or(Datagram{});
    tapped.stamp = stamp;
    tapped.destination_port = options_.port;
    return tapped;
  }
  return {stamp, ntohl(message.sender.sin_addr.s_addr), ntohs(message.sender.sin_port),
          options_.port, message.bytes};
}

tl::unexpected<Error> UdpSource::read_error() const {
  return host::fail_errno("cannot be read", name());
}

std::string UdpSource::name() const {
  if (options_.tap) {
    return "tap of " + options_.interface + ", port " + std::to_string(options_.port);
  }
  return (options_.address.empty() ? "0.0.0.0" : options_.address) + ":" +
         std::to_string(options_.port);
}

}  // namespace infuse::lidar
