#include "daemon/health/health_options.hpp"

namespace infuse::daemon {

std::optional<std::string> HealthOptions::invalid() const {
  const auto outside = [](Duration value) {
    return value < Duration::zero() || value > from_seconds(86400 * 365);
  };
  if (stale_after == Duration::zero() || outside(stale_after)) {
    return "stale_after_s must be positive, and at most a year";
  }
  if (outside(raise_after)) return "raise_after_s must be between 0 and a year";
  if (outside(clear_after)) return "clear_after_s must be between 0 and a year";
  if (outside(clock_grace)) return "clock_grace_s must be between 0 and a year";
  if (!(warn_loss >= 0 && warn_loss <= 1)) return "warn_loss must be between 0 and 1";
  if (!(error_loss >= warn_loss && error_loss <= 1)) {
    return "error_loss must be between warn_loss and 1";
  }
  return std::nullopt;
}

}  // namespace infuse::daemon
