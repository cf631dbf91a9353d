#include "daemon/health/source_checks.hpp"

#include <spdlog/fmt/fmt.h>

namespace infuse::daemon {

std::optional<Problem> check_availability(const SourceState& source) {
  if (source.open) return std::nullopt;
  return Problem{fmt::format("{}; retrying", source.problem.data()),
                 "connect the device, or bring the interface up"};
}

std::optional<Problem> check_bus_off(const SourceState& source) {
  if (!source.bus_off) return std::nullopt;
  return Problem{"CAN controller bus-off",
                 "check bit rate, cable and termination; restart with: ip link set IF type can "
                 "restart, or set restart-ms"};
}

std::optional<Problem> check_bus_state(const SourceState& source) {
  if (source.bus_off || *source.bus_state == '\0') return std::nullopt;
  return Problem{fmt::format("CAN controller {}", source.bus_state),
                 "check bit rate, cable and termination"};
}

std::optional<Problem> check_receive_buffer(const SourceState& source) {
  if (source.buffer_granted >= source.buffer_requested) return std::nullopt;
  return Problem{fmt::format("receive buffer of {} bytes, {} requested", source.buffer_granted,
                             source.buffer_requested),
                 "raise net.core.rmem_max"};
}

}  // namespace infuse::daemon
