#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// Sockets of the daemon and limits of its clients: the `[socket]` table of the configuration.
struct ServerOptions {
  std::string path;                        ///< Unix stream socket; empty: the default path
  uint16_t tcp_port = 0;                   ///< additional port on the loopback; 0: none
  uint32_t max_clients = 64;               ///< maximum number of connections
  uint32_t max_clients_per_user = 16;      ///< maximum number of one user's; not of the owner's
  Duration idle_timeout{900'000'000'000};  ///< silence in both directions that ends a session, ns
  uint32_t queue_reports = 256;            ///< maximum number of reports queued for one client
  double max_requests_hz = 50;  ///< maximum request rate of one user, after a burst of as many

  /// Returns what is wrong with the options, or nothing.
  std::optional<std::string> invalid() const;
};

}  // namespace infuse::daemon
