#include "daemon/config/calibration_settings.hpp"

namespace infuse::daemon {

std::optional<std::string> CalibrationSettings::invalid() const {
  if (auto wrong = monitor.invalid()) return wrong;
  if (auto wrong = supervisor.invalid()) return wrong;
  return reestimate.invalid();
}

}  // namespace infuse::daemon
