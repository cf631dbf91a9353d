#pragma once

#include <cstdint>
#include <string>

#include "daemon/protocol/reports.hpp"

namespace infuse::daemon {

/// Figures besides HEALTH.
struct ProcessStats {
  std::string release;          ///< of the program
  std::string config_digest;    ///< of the configuration at the start
  std::string config_version;   ///< its owner's name of it
  uint64_t alerts = 0;          ///< raised since the start
  uint64_t resident_bytes = 0;  ///< memory; 0: not known
  uint64_t descriptors = 0;     ///< open; 0: not known
};

/// Sets memory and descriptors of this process; the rest is unchanged.
void measure_process(ProcessStats& process);

/// Returns the figures of a HEALTH report in Prometheus' text format, version 0.0.4. Levels are
/// numbers: 0 OK, 1 WARN, 2 ERROR, 3 STALE. Figures that are not known are absent.
std::string metrics_text(const HealthReport& health, const ProcessStats& process);

}  // namespace infuse::daemon
