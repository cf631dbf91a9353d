#pragma once

#include <optional>
#include <string>

#include "fusion/watch/decision.hpp"
#include "fusion/watch/watch.hpp"

namespace infuse::daemon {

/// What the owner wants of the cameras' calibrations. The `[calibration]` table of the
/// configuration.
struct CalibrationSettings {
  bool watched = true;              ///< false: calibrations are taken as they are
  watch::WatchOptions watch;        ///< how they are watched
  watch::DecisionOptions decision;  ///< what is done about them: policy, limits
  watch::ReestimateOptions reestimate;

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

}  // namespace infuse::daemon
