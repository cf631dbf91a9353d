#pragma once

#include <optional>
#include <string>

namespace infuse::daemon {

/// Waits until every sensor of the daemon delivers data and no level of HEALTH but those of
/// calibrations is ERROR or STALE. `socket`: empty for the default. `config_digest`: of the
/// configuration that the daemon must have; empty for any. Returns what it still waits for when the
/// time is over; nothing if the daemon is ready.
std::optional<std::string> wait_until_ready(const std::string& socket, double timeout_s,
                                            const std::string& config_digest = "");

}  // namespace infuse::daemon
