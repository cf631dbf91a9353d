#pragma once

#include <string>

#include "daemon/health/conditions.hpp"
#include "fusion/monitoring/calibration_supervisor.hpp"

namespace infuse::daemon {

/// Status of a camera's calibration, for health checks.
struct CalibrationStatus {
  monitoring::CalibrationState state = monitoring::CalibrationState::kMonitoring;
  monitoring::Axis axis = monitoring::Axis::kRotationX;  ///< with the most evidence for a drift
  double offset = 0;                                     ///< along the axis, rad or m
  double offset_sigma = 0;                               ///< its standard deviation
  double evidence = 0;                                   ///< nats
  double evidence_threshold = 0;                         ///< nats
  monitoring::CameraFault fault = monitoring::CameraFault::kNone;
  std::string reason;  ///< why the last estimate is not usable; empty: none, or it is
};

/// Checks the calibration of one camera. Pure; its states have their own hysteresis.
class CalibrationHealth {
 public:
  CalibrationHealth();

  /// Updates the findings; called with every CALIBRATION report. The result is valid until the next
  /// call.
  const Conditions& update(Stamp now, const CalibrationStatus& status);

 private:
  Conditions conditions_;
};

}  // namespace infuse::daemon
