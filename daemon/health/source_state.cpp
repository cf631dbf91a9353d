#include "daemon/health/source_state.hpp"

#include <spdlog/fmt/fmt.h>

namespace infuse::daemon {

Verdict judge_availability(const SourceState& source) {
  if (source.open) return {};
  return {true, fmt::format("{}; tried again and again", source.problem.data()),
          "plug it in, or bring its interface up"};
}

Verdict judge_bus_off(const SourceState& source) {
  if (!source.bus_off) return {};
  return {true, "the controller is bus-off: it takes part no more",
          "check bit rate, cable and termination; restart it with: ip link set IF type can "
          "restart, or restart-ms"};
}

Verdict judge_bus(const SourceState& source) {
  if (source.bus_off || *source.bus == '\0') return {};
  return {true, fmt::format("the controller is {}", source.bus),
          "check bit rate, cable and termination"};
}

Verdict judge_buffer(const SourceState& source) {
  if (source.buffer_granted >= source.buffer_wanted) return {};
  return {true,
          fmt::format("the receive buffer has {} bytes of the {} that were asked for",
                      source.buffer_granted, source.buffer_wanted),
          "raise net.core.rmem_max"};
}

}  // namespace infuse::daemon
