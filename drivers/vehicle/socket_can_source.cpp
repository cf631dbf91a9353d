#include "drivers/vehicle/socket_can_source.hpp"

#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/ioctl.h>

#include <cstring>

#include "drivers/host/system_error.hpp"

namespace infuse::vehicle {
namespace {

constexpr size_t kMaxFilters = 512;  // CAN_RAW_FILTER_MAX

Result<void> set_filters(int socket, const SocketCanOptions& options) {
  if (options.identifiers.empty() || options.identifiers.size() > kMaxFilters) return {};
  std::vector<can_filter> filters;
  for (const CanIdentifier& wanted : options.identifiers) {
    const canid_t mask = wanted.extended ? CAN_EFF_MASK : CAN_SFF_MASK;
    filters.push_back(
        {(wanted.id & mask) | (wanted.extended ? CAN_EFF_FLAG : 0U), mask | CAN_EFF_FLAG});
  }
  if (setsockopt(socket, SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(),
                 static_cast<socklen_t>(filters.size() * sizeof(can_filter))) != 0) {
    return host::fail_errno("cannot set the kernel's filters", options.interface);
  }
  return {};
}

}  // namespace

std::optional<std::string> SocketCanOptions::invalid() const {
  if (interface.empty() || interface.size() >= IF_NAMESIZE) {
    return "'" + interface + "' is not an interface name";
  }
  if (receive_buffer == 0) return "the receive buffer size must not be 0";
  return std::nullopt;
}

Result<SocketCanSource> SocketCanSource::open(const SocketCanOptions& options,
                                              const host::TimeBase& base) {
  if (auto wrong = options.invalid()) return fail(*wrong, options.interface);
  SocketCanSource source(options, base);
  if (const auto ready = source.set_up(); !ready) return tl::unexpected(ready.error());
  return source;
}

Result<void> SocketCanSource::set_up() {
  const std::string& name = options_.interface;
  socket_ = host::FileDescriptor(socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW));
  if (!socket_) {
    return host::fail_errno("the kernel does not support CAN", name, "load the module can_raw");
  }
  const int on = 1;
  setsockopt(socket_.get(), SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof(on));
  const can_err_mask_t errors = CAN_ERR_MASK;
  setsockopt(socket_.get(), SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof(errors));
  if (auto filtered = set_filters(socket_.get(), options_); !filtered) return filtered;
  if (const auto size = host::prepare_socket(socket_.get(), options_.receive_buffer, name); !size) {
    return tl::unexpected(size.error());
  }
  host::request_hardware_stamps(socket_.get());
  sockaddr_can bus{};
  bus.can_family = AF_CAN;
  bus.can_ifindex = static_cast<int>(if_nametoindex(name.c_str()));
  if (bus.can_ifindex == 0)
    return fail("no such interface", name, "check that the adapter is plugged in");
  if (bind(socket_.get(), reinterpret_cast<const sockaddr*>(&bus), sizeof(bus)) != 0) {
    return host::fail_errno("cannot bind", name, errno == ENODEV ? "not a CAN interface" : "");
  }
  frame_.set_interface(name);
  return {};
}

bool SocketCanSource::up() const {
  ifreq request{};
  options_.interface.copy(request.ifr_name, IF_NAMESIZE - 1);
  return ioctl(socket_.get(), SIOCGIFFLAGS, &request) == 0 && (request.ifr_flags & IFF_UP) != 0;
}

bool SocketCanSource::process_message(const host::MessageBatch::Message& message) {
  if (message.truncated || !parse_socket_can(message.bytes, frame_)) return false;
  // To the microsecond, as in a candump log: a recording of the bus replays identically.
  const Stamp stamp =
      hardware_stamps_.update(message.hardware_ns, message.stamp, message.interface);
  frame_.stamp = stamp - Duration(stamp.ns() % 1000);
  bus_errors_.process(frame_);
  return true;
}

Result<size_t> SocketCanSource::handle_read_error() {
  if (errno != ENETDOWN) return host::fail_errno("cannot be read", options_.interface);
  bus_errors_.reset();
  return 0;
}

bool parse_socket_can(std::span<const uint8_t> bytes, CanFrame& frame) {
  canfd_frame raw{};
  if (bytes.size() != CAN_MTU && bytes.size() != CANFD_MTU) return false;
  std::memcpy(&raw, bytes.data(), bytes.size());
  frame.fd = bytes.size() == CANFD_MTU;
  frame.error = (raw.can_id & CAN_ERR_FLAG) != 0;
  frame.remote = (raw.can_id & CAN_RTR_FLAG) != 0;
  frame.extended = !frame.error && (raw.can_id & CAN_EFF_FLAG) != 0;
  frame.id = raw.can_id & (frame.extended || frame.error ? CAN_EFF_MASK : CAN_SFF_MASK);
  frame.fd_flags = frame.fd ? raw.flags & (CANFD_BRS | CANFD_ESI) : 0;
  frame.length = std::min<uint8_t>(raw.len, frame.fd ? CANFD_MAX_DLEN : CAN_MAX_DLEN);
  if (frame.remote) frame.length = 0;
  frame.data.fill(0);
  std::memcpy(frame.data.data(), raw.data, frame.length);
  return true;
}

}  // namespace infuse::vehicle
