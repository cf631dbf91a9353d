#include "daemon/config/record_settings.hpp"

namespace infuse::daemon {

std::optional<std::string> RecordSettings::invalid() const {
  constexpr uint64_t kMiB = 1 << 20;
  if (memory < 4 * kMiB || memory > 4096 * kMiB) return "memory_mb must be between 4 and 4096";
  if (flight_recorder < Duration::zero() || flight_recorder > from_seconds(600)) {
    return "flight_recorder_s must be between 0 and 600";
  }
  if (after_alert < Duration::zero() || after_alert > from_seconds(600)) {
    return "after_alert_s must be between 0 and 600";
  }
  if (keep_alerts == 0 || keep_alerts > 1000) return "keep_alerts must be between 1 and 1000";
  if (alert_pause < Duration::zero() || alert_pause > from_seconds(86'400)) {
    return "alert_pause_s must be between 0 and 86400";
  }
  if (budget < kMiB) return "budget_mb must be at least 1";
  if (max_duration < from_seconds(1)) return "max_duration_s must be at least 1";
  if (max_bytes < kMiB) return "max_size_mb must be at least 1";
  if (split != Duration::zero() && split < from_seconds(1)) return "split_s must be at least 1";
  if (split_bytes != 0 && split_bytes < kMiB) return "split_mb must be at least 1";
  return std::nullopt;
}

}  // namespace infuse::daemon
