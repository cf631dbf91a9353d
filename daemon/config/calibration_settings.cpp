#include "daemon/config/calibration_settings.hpp"

namespace infuse::daemon {

std::optional<std::string> CalibrationSettings::invalid() const {
  if (auto wrong = watch.invalid()) return wrong;
  if (auto wrong = decision.invalid()) return wrong;
  return reestimate.invalid();
}

}  // namespace infuse::daemon
