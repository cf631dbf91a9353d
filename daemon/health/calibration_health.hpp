#pragma once

#include <string>

#include "daemon/health/conditions.hpp"

namespace infuse::daemon {

/// What is judged of a camera's calibration.
struct CalibrationStatus {
  std::string state;        ///< as CALIBRATION tells it
  std::string axis;         ///< along which it seems to have moved
  double offset = 0;        ///< by how much, in `unit`
  double offset_sigma = 0;  ///< standard deviation of that
  const char* unit = "";    ///< "°" or "cm"
  double evidence = 0;      ///< nats
  double evidence_threshold = 0;
  std::string fault;   ///< of the camera itself; empty: none
  std::string reason;  ///< why the last estimate cannot be used
};

/// Turns the state of one camera's calibration into findings. Pure; the states have their own
/// hysteresis.
class CalibrationHealth {
 public:
  CalibrationHealth();

  /// After every CALIBRATION report. The answer is valid until the next call.
  const Conditions& update(Stamp now, const CalibrationStatus& figures);

 private:
  Conditions conditions_;
};

}  // namespace infuse::daemon
