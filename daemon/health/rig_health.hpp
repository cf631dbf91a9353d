#pragma once

#include <span>
#include <string>
#include <vector>

#include "daemon/health/alert.hpp"

namespace infuse::daemon {

/// What is configured, and what must be.
struct RigStatus {
  const std::vector<std::string>& names;     ///< of the configured devices
  const std::vector<std::string>& expected;  ///< `HealthOptions::expected_sensors`
};

/// The alerts about the configured devices. Without them, a daemon that has lost a part of its
/// configuration would look healthy.
std::span<const Alert<RigStatus>> rig_alerts();

}  // namespace infuse::daemon
