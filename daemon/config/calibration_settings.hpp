#pragma once

#include <optional>
#include <string>

#include "fusion/monitoring/calibration_monitor.hpp"
#include "fusion/monitoring/calibration_supervisor.hpp"

namespace infuse::daemon {

/// What the owner wants of the cameras' calibrations. The `[calibration]` table of the
/// configuration.
struct CalibrationSettings {
  bool monitored = true;                     ///< false: calibrations are taken as they are
  monitoring::MonitorOptions monitor;        ///< how they are watched
  monitoring::SupervisorOptions supervisor;  ///< what is done about them: policy, limits
  monitoring::ReestimateOptions reestimate;

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

}  // namespace infuse::daemon
