#include "daemon/health/odometry_health.hpp"

#include <spdlog/fmt/fmt.h>

namespace infuse::daemon {

OdometryHealth::OdometryHealth(const HealthOptions& options)
    : conditions_{{"untrusted", Level::kError, options.raise_after, options.clear_after},
                  {"uncompensated", Level::kWarn, options.raise_after, options.clear_after}} {}

const Conditions& OdometryHealth::update(Stamp now, const OdometryFigures& figures) {
  const uint64_t uncompensated = figures.uncompensated - uncompensated_;
  uncompensated_ = figures.uncompensated;
  Verdict untrusted, straight;
  if (!figures.usable()) {
    untrusted = {true, fmt::format("odometry cannot be trusted: {}", figures.reason),
                 "check wheel speeds and yaw rate on the bus, and the inertial unit"};
  }
  if (uncompensated > 0) {
    straight = {
        true,
        fmt::format("{} sweeps of the last second were not corrected for motion", uncompensated),
        "see each SWEEP's straight_reason"};
  }
  conditions_.judge({untrusted, straight}, now);
  return conditions_;
}

}  // namespace infuse::daemon
