#pragma once

#include <cstdint>
#include <string>

#include "fusion/monitoring/calibration_supervisor.hpp"

namespace infuse::daemon {

/// What the guard of a camera is to do, as the owner has decided.
struct CalibrationCommand {
  enum class Kind : uint8_t { kUse, kRecalibrate, kFreeze };
  Kind kind = Kind::kUse;
  std::string camera;
  monitoring::OwnerCalibration calibration;  ///< of kUse
  bool frozen = true;                        ///< of kFreeze
  uint64_t decision = 0;  ///< counts decisions: a report states the last it knows
};

}  // namespace infuse::daemon
