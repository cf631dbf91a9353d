#include "daemon/health/rig_health.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

namespace infuse::daemon {

RigHealth::RigHealth()
    : conditions_{{"missing_sensors", Level::kError, Duration::zero(), Duration::zero()},
                  {"no_sensors", Level::kWarn, Duration::zero(), Duration::zero()}} {}

const Conditions& RigHealth::update(Stamp now, const std::vector<std::string>& names,
                                    const HealthOptions& options) {
  std::string missing;
  for (const std::string& expected : options.expected_sensors) {
    if (std::find(names.begin(), names.end(), expected) != names.end()) continue;
    missing += (missing.empty() ? "" : ", ") + expected;
  }
  const char* advice = "check the configuration and its drop-ins with infused --check-config";
  CheckResult without, none;
  if (!missing.empty()) {
    without = {true, fmt::format("expected but not configured: {}", missing), advice};
  }
  if (names.empty()) none = {true, "no sensor is configured", advice};
  conditions_.update({without, none}, now);
  return conditions_;
}

}  // namespace infuse::daemon
