#pragma once

#include <cstdint>
#include <string>

#include "daemon/protocol/counters_json.hpp"

namespace infuse::daemon {

/// What is told besides HEALTH.
struct ProcessStats {
  std::string release;          ///< of the program
  uint64_t alerts = 0;          ///< raised since the start
  uint64_t resident_bytes = 0;  ///< memory; 0: not known
  uint64_t descriptors = 0;     ///< open; 0: not known
};

/// Memory and descriptors of this process as the kernel has them; the rest is left.
void measure_process(ProcessStats& figures);

/// Every figure of a HEALTH report in Prometheus' text format, version 0.0.4. Levels are numbers: 0
/// OK, 1 WARN, 2 ERROR, 3 STALE. What HEALTH leaves out is absent.
std::string metrics_text(const Json& health, const ProcessStats& process);

}  // namespace infuse::daemon
