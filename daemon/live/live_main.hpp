#pragma once

#include <string>

#include "daemon/config/config.hpp"
#include "daemon/server/server.hpp"

namespace infuse::daemon {

/// What `infused --config` is told.
struct LiveArguments {
  std::string config;   ///< file; read again on SIGHUP
  std::string socket;   ///< where clients connect; empty: as configured, or the service manager's
  std::string release;  ///< of the program
  std::string session;  ///< of this start
};

/// Runs the sensors of this host until SIGTERM or SIGINT. The exit code.
int run_live(const LiveArguments& arguments, const Config& config);

/// Where clients connect: the service manager's sockets, `socket`, the configured place, or the
/// first default one, which is done without where it cannot be. Also TCP on the loopback where it
/// is configured.
Result<void> listen(Server& server, const std::string& socket, const ServerOptions& options);

}  // namespace infuse::daemon
