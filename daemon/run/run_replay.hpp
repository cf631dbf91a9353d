#pragma once

#include "daemon/config/config.hpp"
#include "daemon/run/run_options.hpp"

namespace infuse::daemon {

/// Runs the pipeline on a recorded drive or a capture until its end, SIGTERM or SIGINT, and prints
/// a summary. Returns the exit code.
int run_replay(const RunOptions& options, const Config& config);

}  // namespace infuse::daemon
