#include "daemon/health/source_state.hpp"

#include <spdlog/fmt/fmt.h>

namespace infuse::daemon {

CheckResult check_availability(const SourceState& source) {
  if (source.open) return {};
  return {true, fmt::format("{}; tried again and again", source.problem.data()),
          "plug it in, or bring its interface up"};
}

CheckResult check_bus_off(const SourceState& source) {
  if (!source.bus_off) return {};
  return {true, "the controller is bus-off: it takes part no more",
          "check bit rate, cable and termination; restart it with: ip link set IF type can "
          "restart, or restart-ms"};
}

CheckResult check_bus_state(const SourceState& source) {
  if (source.bus_off || *source.bus_state == '\0') return {};
  return {true, fmt::format("the controller is {}", source.bus_state),
          "check bit rate, cable and termination"};
}

CheckResult check_receive_buffer(const SourceState& source) {
  if (source.buffer_granted >= source.buffer_requested) return {};
  return {true,
          fmt::format("the receive buffer has {} bytes of the {} that were requested",
                      source.buffer_granted, source.buffer_requested),
          "raise net.core.rmem_max"};
}

}  // namespace infuse::daemon
