#include "daemon/protocol/json.hpp"

#include "daemon/protocol/json_encoder.hpp"

namespace infuse::daemon {

std::string json_text(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

Json to_json(const ClockState& clock) { return encode(clock); }

Json losses_json(const LidarCounters& counters) { return encode(PacketLosses{counters}); }

Json latency_ms_json(const LatencyStats& latency) { return encode(latency); }

}  // namespace infuse::daemon
