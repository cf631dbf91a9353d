#pragma once

#include <optional>

#include "daemon/health/alert.hpp"
#include "daemon/health/source_state.hpp"

namespace infuse::daemon {

// Checks of what live sensors of every kind share.

/// Check of the condition "unavailable": the source is not open.
std::optional<Problem> check_availability(const SourceState& source);
/// Check of the condition "bus_off".
std::optional<Problem> check_bus_off(const SourceState& source);
/// Check of the condition "bus_errors".
std::optional<Problem> check_bus_state(const SourceState& source);
/// Check of the condition "receive_buffer": the kernel granted less than requested.
std::optional<Problem> check_receive_buffer(const SourceState& source);

}  // namespace infuse::daemon
