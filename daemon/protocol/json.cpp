#include "daemon/protocol/json.hpp"

#include "daemon/protocol/json_encoder.hpp"

namespace infuse::daemon {

Json to_json(const ClockState& clock) { return encode(clock); }

Json losses_json(const SensorCounters& counters) { return encode(PacketLosses{counters}); }

Json latency_ms_json(const LatencyStats& latency) { return encode(latency); }

}  // namespace infuse::daemon
