#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// Where the daemon is listened to, and what a client may cost. The `[socket]` table of the
/// configuration.
struct ServerOptions {
  std::string path;                        ///< Unix stream socket; empty: the default place
  uint16_t tcp_port = 0;                   ///< on the loopback besides; 0: none
  uint32_t max_clients = 64;               ///< connections at a time
  Duration idle_timeout{900'000'000'000};  ///< silence both ways after which a client is let go, ns
  uint32_t queue_reports = 256;  ///< reports that wait for one client before it loses some
  double max_requests_hz = 50;   ///< requests a second from one client, after a burst of as many

  /// What is wrong with the numbers, or nothing.
  std::optional<std::string> invalid() const;
};

}  // namespace infuse::daemon
