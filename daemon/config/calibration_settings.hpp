#pragma once

#include <optional>
#include <string>

#include "fusion/monitoring/calibration_monitor.hpp"
#include "fusion/monitoring/calibration_supervisor.hpp"

namespace infuse::daemon {

/// Settings of the cameras' calibrations: the `[calibration]` table of the configuration.
struct CalibrationSettings {
  bool monitored = true;                     ///< false: calibrations are used unchecked
  monitoring::MonitorOptions monitor;        ///< drift detection
  monitoring::SupervisorOptions supervisor;  ///< policy, limits
  monitoring::ReestimateOptions reestimate;

  /// Returns what is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

}  // namespace infuse::daemon
