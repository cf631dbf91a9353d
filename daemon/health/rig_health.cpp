#include "daemon/health/rig_health.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

namespace infuse::daemon {
namespace {

constexpr const char* kRigAdvice =
    "check the configuration and its drop-ins with infused --check-config";

constexpr Alert<RigStatus> kRigAlerts[] = {
    {{"missing_sensors", Level::kError, Delays::kNone,
      "One of expected_sensors is not configured. Check the configuration and its drop-ins with "
      "`infused --check-config`."},
     [](const RigStatus& rig) -> std::optional<Problem> {
       std::string missing;
       for (const std::string& expected : rig.expected) {
         if (std::find(rig.names.begin(), rig.names.end(), expected) != rig.names.end()) continue;
         missing += (missing.empty() ? "" : ", ") + expected;
       }
       if (missing.empty()) return {};
       return Problem{fmt::format("expected but not configured: {}", missing), kRigAdvice};
     }},
    {{"no_sensors", Level::kWarn, Delays::kNone,
      "No sensor is configured. Check the configuration and its drop-ins with `infused "
      "--check-config`."},
     [](const RigStatus& rig) -> std::optional<Problem> {
       if (!rig.names.empty()) return {};
       return Problem{"no sensor is configured", kRigAdvice};
     }},
};

}  // namespace

std::span<const Alert<RigStatus>> rig_alerts() { return kRigAlerts; }

}  // namespace infuse::daemon
