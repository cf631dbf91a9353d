#include "daemon/health/odometry_health.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

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

// Page's test (1954) of samples that contradict as often as not against those of a source that errs
// as its sigmas say: with one mode, at most 4 / (9 k²) of its errors lie beyond k standard
// deviations, whatever they are distributed as (Vysochanskij and Petunin 1980).
constexpr double kWrong = 0.5;
constexpr double kRight = 4 / (9 * motion::kGateSigmas * motion::kGateSigmas);
constexpr double kSure = 1e-6;  // a false verdict in a million samples, on average (Lorden 1971)

/// What samples add to the evidence that a source is wrong.
double evidence(uint64_t rejected, uint64_t accepted) {
  return static_cast<double>(rejected) * std::log(kWrong / kRight) +
         static_cast<double>(accepted) * std::log((1 - kWrong) / (1 - kRight));
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
      "More samples of a source are rejected than its standard deviations allow. Wheels: slip, or "
      "a tyre changed; GNSS: reflections; lidar: moving objects."},
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
    : raise_after_(options.raise_after), checks_(odometry_alerts(), options) {}

// It takes as much evidence that a source is right again. A moment counts for as long as a
// condition must last to raise an alert.
std::string OdometryHealth::contradicting(Stamp now, const OdometrySourceStatuses& sources) {
  const double sure = -std::log(kSure);
  std::string names;
  for (size_t i = 0; i < sources.size(); ++i) {
    Verdict& verdict = verdicts_[i];
    const uint64_t rejected = sources[i].rejected - before_[i].rejected;
    const uint64_t accepted = sources[i].accepted - before_[i].accepted;
    verdict.evidence = std::clamp(verdict.evidence + evidence(rejected, accepted), 0.0, sure);
    if (verdict.evidence >= sure) verdict.contradicts = true;
    if (verdict.evidence <= 0) verdict.contradicts = false;
    if (verdict.contradicts) verdict.last = now;
    if (verdict.last == Stamp::earliest() || now - verdict.last > raise_after_) continue;
    names += (names.empty() ? "" : ", ") + std::string(sources[i].name);
  }
  before_ = sources;
  return names;
}

const AlertChecks<OdometryTick>& OdometryHealth::update(Stamp now, const OdometryStatus& status) {
  const std::string names = contradicting(now, status.sources);
  const uint64_t not_deskewed = status.not_deskewed - not_deskewed_;
  not_deskewed_ = status.not_deskewed;
  return checks_.update(now, {status, names, not_deskewed});
}

}  // namespace infuse::daemon
