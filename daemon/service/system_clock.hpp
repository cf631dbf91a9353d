#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "daemon/health/host_alerts.hpp"
#include "drivers/host/file_descriptor.hpp"

namespace infuse::daemon {

/// State of the host's clock by chrony's answer to "tracking" (its candm.h, protocol 6); nothing if
/// the bytes are none.
std::optional<SystemClock> parse_chrony_tracking(std::span<const uint8_t> answer);

/// Asks how the host's clock is kept: chrony, by UDP on the loopback, which the service's sandbox
/// permits; without it the kernel (adjtimex), which it does not. Never waits.
class SystemClockQuery {
 public:
  /// `port`: chrony's cmdport.
  explicit SystemClockQuery(uint16_t port = 323);

  /// Called once a second: returns what chrony has answered since the last call, or what the kernel
  /// says; nothing if neither says anything.
  std::optional<SystemClock> ask();

 private:
  host::FileDescriptor socket_;
  std::optional<SystemClock> last_;
  int unanswered_ = 0;
};

}  // namespace infuse::daemon
