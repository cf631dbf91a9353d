#include "daemon/health/odometry_health.hpp"

#include <spdlog/fmt/fmt.h>

namespace infuse::daemon {
namespace {

/// Names of the sources that carry the odometry: "wheels, gyro".
std::string carriers(const OdometrySourceStatuses& sources) {
  std::string names;
  for (const OdometrySourceStatus& source : sources) {
    if (source.carries) names += (names.empty() ? "" : ", ") + std::string(source.name);
  }
  return names.empty() ? "nothing" : names;
}

/// Names of the sources of which most samples were rejected between two updates.
std::string contradicting(const OdometrySourceStatuses& before, const OdometrySourceStatuses& now) {
  std::string names;
  for (size_t i = 0; i < now.size(); ++i) {
    const uint64_t rejected = now[i].rejected - before[i].rejected;
    const uint64_t accepted = now[i].accepted - before[i].accepted;
    if (rejected > accepted) names += (names.empty() ? "" : ", ") + std::string(now[i].name);
  }
  return names;
}

}  // namespace

OdometryHealth::OdometryHealth(const HealthOptions& options)
    : conditions_{{"untrusted", Level::kError, options.raise_after, options.clear_after},
                  {"contradiction", Level::kWarn, options.raise_after, options.clear_after},
                  {"not_deskewed", Level::kWarn, options.raise_after, options.clear_after}} {}

const Conditions& OdometryHealth::update(Stamp now, const OdometryStatus& status) {
  const uint64_t not_deskewed = status.not_deskewed - not_deskewed_;
  not_deskewed_ = status.not_deskewed;
  const std::string names = contradicting(sources_, status.sources);
  sources_ = status.sources;
  CheckResult untrusted, contradiction, not_deskewed_check;
  if (!status.usable()) {
    untrusted = {true, fmt::format("odometry not usable: {}", status.reason),
                 "add or check wheel speeds and yaw rate on the bus, an inertial unit, a GNSS "
                 "receiver with speed and course, or use_lidar in [odometry]"};
  }
  if (!names.empty()) {
    contradiction = {
        true,
        fmt::format("{} contradicts the motion carried by {}", names, carriers(status.sources)),
        "wheels: slip, or a tyre changed; GNSS: reflections; lidar: moving objects"};
  }
  if (not_deskewed > 0) {
    not_deskewed_check = {true,
                          fmt::format("{} sweeps not deskewed in the last second", not_deskewed),
                          "see deskew_reason in the SWEEP reports"};
  }
  conditions_.update({untrusted, contradiction, not_deskewed_check}, now);
  return conditions_;
}

}  // namespace infuse::daemon
