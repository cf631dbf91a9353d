#include "daemon/health/odometry_health.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>

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

/// True if more samples were rejected than single outliers explain.
bool beyond_chance(uint64_t rejected, uint64_t samples) {
  constexpr double kOutliers = 0.02;  // part of the samples of a source that is right, at most
  constexpr double kLevel = 1e-6;     // once in 11 days, at a check a second
  if (rejected == 0) return false;
  const boost::math::binomial_distribution<> outliers(static_cast<double>(samples), kOutliers);
  return cdf(complement(outliers, static_cast<double>(rejected - 1))) < kLevel;
}

struct Counts {
  uint64_t rejected, samples;
  Counts(const OdometrySourceStatus& before, const OdometrySourceStatus& now)
      : rejected(now.rejected - before.rejected),
        samples(rejected + now.accepted - before.accepted) {}
};

constexpr Duration kUpdates{1'000'000'000};  // ns between updates, about

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
      "Most samples of a source are rejected, or more within a moment than chance explains. "
      "Wheels: "
      "slip, or a tyre changed; GNSS: reflections; "
      "lidar: moving objects."},
     [](const OdometryTick& tick) -> std::optional<Problem> {
       if (tick.contradicting.empty()) return {};
       return Problem{
           fmt::format("the motion measured by {} is contradicted by {}",
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

OdometryHealth::OdometryHealth(const HealthOptions& options)
    : before_(static_cast<size_t>(options.raise_after / kUpdates) + 1),
      checks_(odometry_alerts(), options) {}

// A moment counts for as long as a condition must last to raise an alert.
std::string OdometryHealth::contradicting(const OdometrySourceStatuses& now) const {
  std::string names;
  for (size_t i = 0; i < now.size(); ++i) {
    const Counts last(before_.back()[i], now[i]), all(before_.front()[i], now[i]);
    const bool most = 2 * last.rejected > last.samples;
    if (!most && !beyond_chance(all.rejected, all.samples)) continue;
    names += (names.empty() ? "" : ", ") + std::string(now[i].name);
  }
  return names;
}

const AlertChecks<OdometryTick>& OdometryHealth::update(Stamp now, const OdometryStatus& status) {
  const std::string names = contradicting(status.sources);
  const uint64_t not_deskewed = status.not_deskewed - not_deskewed_;
  std::rotate(before_.begin(), before_.begin() + 1, before_.end());
  before_.back() = status.sources;
  not_deskewed_ = status.not_deskewed;
  return checks_.update(now, {status, names, not_deskewed});
}

}  // namespace infuse::daemon
