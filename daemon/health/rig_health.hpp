#pragma once

#include <string>
#include <vector>

#include "daemon/health/conditions.hpp"
#include "daemon/health/health_options.hpp"

namespace infuse::daemon {

/// Checks that sensors are configured at all, and the expected ones among them. Without it, a
/// daemon that has lost a part of its configuration would look healthy. Pure.
class RigHealth {
 public:
  RigHealth();

  /// Updates the findings; `names` are those of the configured devices. Called about once a second.
  /// The result is valid until the next call.
  const Conditions& update(Stamp now, const std::vector<std::string>& names,
                           const HealthOptions& options);

 private:
  Conditions conditions_;
};

}  // namespace infuse::daemon
