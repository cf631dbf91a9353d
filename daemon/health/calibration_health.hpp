#pragma once

#include <span>
#include <string>

#include "daemon/health/alert.hpp"
#include "fusion/monitoring/calibration_states.hpp"
#include "fusion/monitoring/drift_verdict.hpp"

namespace infuse::daemon {

/// Status of a camera's calibration, for health checks.
struct CalibrationStatus {
  monitoring::CalibrationState state;
  const monitoring::DriftVerdict& verdict;
  std::string reason;  ///< why the last estimate is not usable; empty: none, or it is
};

/// The alerts of the calibration of one camera, the worst first. Its states have their own
/// hysteresis.
std::span<const Alert<CalibrationStatus>> calibration_alerts();

}  // namespace infuse::daemon
