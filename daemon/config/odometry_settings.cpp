#include "daemon/config/odometry_settings.hpp"

namespace infuse::daemon {

std::optional<std::string> OdometrySettings::invalid() const {
  if (auto wrong = filter.invalid()) return wrong;
  if (max_wait < Duration::zero() || max_wait > Duration{5'000'000'000}) {
    return "max_wait_ms must be between 0 and 5000";
  }
  if (!(max_heading_sigma > 0)) return "max_heading_sigma_deg must be positive";
  return std::nullopt;
}

}  // namespace infuse::daemon
