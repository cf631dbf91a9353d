#include "daemon/health/odometry_health.hpp"

#include <spdlog/fmt/fmt.h>

namespace infuse::daemon {
namespace {

/// Names of the sources that carry the odometry, but for those that contradict it: "wheels, gyro".
std::string carriers(const OdometrySourceStatuses& sources, const std::string& contradicting) {
  std::string names;
  for (const OdometrySourceStatus& source : sources) {
    if (!source.carries || contradicting.find(source.name) != std::string::npos) continue;
    names += (names.empty() ? "" : ", ") + std::string(source.name);
  }
  return names.empty() ? "nothing else" : names;
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

constexpr Alert<OdometryTick> kOdometryAlerts[] = {
    {{"untrusted", Level::kError, Delays::kBoth,
      "Not usable, with the reason. Add or check wheel speeds and yaw rate on the bus, an inertial "
      "unit, a GNSS receiver with speed and course, or use_lidar."},
     [](const OdometryTick& tick) -> std::optional<Problem> {
       if (tick.status.usable()) return {};
       return Problem{fmt::format("odometry not usable: {}", tick.status.reason),
                      "add or check wheel speeds and yaw rate on the bus, an inertial unit, a GNSS "
                      "receiver with speed and course, or use_lidar in [odometry]"};
     }},
    {{"contradiction", Level::kWarn, Delays::kBoth,
      "Most samples of a source are rejected. Wheels: slip, or a tyre changed; GNSS: reflections; "
      "lidar: moving objects."},
     [](const OdometryTick& tick) -> std::optional<Problem> {
       if (tick.contradicting.empty()) return {};
       return Problem{
           fmt::format("the motion carried by {} is contradicted by {}",
                       carriers(tick.status.sources, tick.contradicting), tick.contradicting),
           "wheels: slip, or a tyre changed; GNSS: reflections; lidar: moving objects"};
     }},
    {{"not_deskewed", Level::kWarn, Delays::kBoth,
      "Sweeps were passed on as measured. See deskew_reason in the SWEEP reports."},
     [](const OdometryTick& tick) -> std::optional<Problem> {
       if (tick.not_deskewed == 0) return {};
       return Problem{fmt::format("{} sweeps not deskewed in the last second", tick.not_deskewed),
                      "see deskew_reason in the SWEEP reports"};
     }},
};

}  // namespace

std::span<const Alert<OdometryTick>> odometry_alerts() { return kOdometryAlerts; }

const AlertChecks<OdometryTick>& OdometryHealth::update(Stamp now, const OdometryStatus& status) {
  const std::string names = contradicting(sources_, status.sources);
  const uint64_t not_deskewed = status.not_deskewed - not_deskewed_;
  sources_ = status.sources;
  not_deskewed_ = status.not_deskewed;
  return checks_.update(now, {status, names, not_deskewed});
}

}  // namespace infuse::daemon
