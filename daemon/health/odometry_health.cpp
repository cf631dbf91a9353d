#include "daemon/health/odometry_health.hpp"

#include <spdlog/fmt/fmt.h>

namespace infuse::daemon {

OdometryHealth::OdometryHealth(const HealthOptions& options)
    : conditions_{{"untrusted", Level::kError, options.raise_after, options.clear_after},
                  {"not_deskewed", Level::kWarn, options.raise_after, options.clear_after}} {}

const Conditions& OdometryHealth::update(Stamp now, const OdometryStatus& status) {
  const uint64_t not_deskewed = status.not_deskewed - not_deskewed_;
  not_deskewed_ = status.not_deskewed;
  CheckResult untrusted, not_deskewed_check;
  if (!status.usable()) {
    untrusted = {true, fmt::format("odometry not usable: {}", status.reason),
                 "check wheel speeds and yaw rate on the bus, and the inertial unit"};
  }
  if (not_deskewed > 0) {
    not_deskewed_check = {true,
                          fmt::format("{} sweeps not deskewed in the last second", not_deskewed),
                          "see deskew_reason in the SWEEP reports"};
  }
  conditions_.update({untrusted, not_deskewed_check}, now);
  return conditions_;
}

}  // namespace infuse::daemon
