#pragma once

#include <iosfwd>

#include "daemon/config/config.hpp"

namespace infuse::daemon {

/// Sets up what a live run with this configuration would: sensors and maps. Prints what is probably
/// unintended, and what does not exist at present: the daemon waits for it. Errors: what the daemon
/// would refuse.
Result<void> check_config(const Config& config, std::ostream& out);

}  // namespace infuse::daemon
