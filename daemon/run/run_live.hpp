#pragma once

#include "daemon/config/config.hpp"
#include "daemon/run/run_options.hpp"

namespace infuse::daemon {

/// Runs the sensors of this host until SIGTERM or SIGINT. Returns the exit code.
int run_live(const RunOptions& options, const Config& config);

}  // namespace infuse::daemon
