#include "daemon/health/calibration_health.hpp"

#include <spdlog/fmt/fmt.h>

namespace infuse::daemon {
namespace {

/// "seems to have turned: rotation about y, +0.52 ± 0.03 ° (evidence 20 of 17 nats)".
std::string describe_drift(const CalibrationStatus& status) {
  return fmt::format("{}, by {:+.2f} ± {:.2f} {} (evidence {:.1f} of {:.1f} nats)", status.axis,
                     status.offset, status.offset_sigma, status.unit, status.evidence,
                     status.evidence_threshold);
}

}  // namespace

CalibrationHealth::CalibrationHealth()
    : conditions_{{"calibration_unusable", Level::kError, Duration::zero(), Duration::zero()},
                  {"drift_confirmed", Level::kError, Duration::zero(), Duration::zero()},
                  {"camera_fault", Level::kError, Duration::zero(), Duration::zero()},
                  {"drift_suspected", Level::kWarn, Duration::zero(), Duration::zero()},
                  {"calibration_changed", Level::kWarn, Duration::zero(), Duration::zero()}} {}

const Conditions& CalibrationHealth::update(Stamp now, const CalibrationStatus& status) {
  CheckResult unusable, confirmed, fault, suspected, changed;
  if (!status.fault.empty()) {
    fault = {true, "the camera is at fault: " + status.fault,
             "look at the camera, its lens and its cable; its calibration is left alone meanwhile"};
  } else if (status.state == "UNUSABLE") {
    unusable = {true, "the calibration must not be used: " + status.reason,
                "look at the camera's mount; calibrate anew with infuse calibrate"};
  }
  if (status.state == "CONFIRMED" || status.state == "RECALIBRATING") {
    confirmed = {true, "the calibration has drift confirmed: " + describe_drift(status),
                 "look at the camera's mount; see infuse calibration, then infuse apply"};
  }
  if (status.state == "SUSPECTED") {
    suspected = {true, "the calibration may have drift confirmed: " + describe_drift(status),
                 "drive on through places with texture; see infuse calibration"};
  }
  if (status.state == "RECALIBRATED") {
    changed = {true, "a new calibration is in use, on probation",
               "see infuse calibration; infuse rollback takes it back"};
  }
  conditions_.update({unusable, confirmed, fault, suspected, changed}, now);
  return conditions_;
}

}  // namespace infuse::daemon
