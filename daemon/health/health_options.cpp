#include "daemon/health/health_options.hpp"

namespace infuse::daemon {

std::optional<std::string> HealthOptions::invalid() const {
  if (stale_after <= Duration::zero()) return "stale_after_s must be positive";
  if (raise_after < Duration::zero()) return "raise_after_s must not be negative";
  if (clear_after < Duration::zero()) return "clear_after_s must not be negative";
  if (clock_grace < Duration::zero()) return "clock_grace_s must not be negative";
  if (!(warn_loss >= 0 && warn_loss <= 1)) return "warn_loss must lie between 0 and 1";
  if (!(error_loss >= warn_loss && error_loss <= 1)) {
    return "error_loss must lie between warn_loss and 1";
  }
  return std::nullopt;
}

}  // namespace infuse::daemon
