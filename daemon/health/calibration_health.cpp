#include "daemon/health/calibration_health.hpp"

#include <spdlog/fmt/fmt.h>

#include "drivers/measurement/angles.hpp"

namespace infuse::daemon {
namespace {

using monitoring::Axis;
using monitoring::CalibrationState;

/// Returns "rotation about y, by +0.52 ± 0.03 ° (evidence 20 of 17 nats)".
std::string describe_drift(const CalibrationStatus& status) {
  const Axis axis = monitoring::base_axis(status.axis);
  std::string offset;
  if (axis != Axis::kTime) {
    const bool rotation = axis <= Axis::kRotationZ;
    const double factor = rotation ? 1 / kDegree : 100;
    offset = fmt::format(", by {:+.2f} ± {:.2f} {}", status.offset * factor,
                         status.offset_sigma * factor, rotation ? "°" : "cm");
  }
  return fmt::format("{}{} (evidence {:.1f} of {:.1f} nats)", monitoring::name_of(axis), offset,
                     status.evidence, status.evidence_threshold);
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
  if (status.fault != monitoring::CameraFault::kNone) {
    fault = {true, std::string("camera fault: ") + monitoring::name_of(status.fault),
             "check the camera, its lens and its cable; the calibration is left unchanged"};
  } else if (status.state == CalibrationState::kUnusable) {
    unusable = {true, "calibration not usable: " + status.reason,
                "check the camera mount; recalibrate with infuse calibrate"};
  }
  if (status.state == CalibrationState::kConfirmed ||
      status.state == CalibrationState::kRecalibrating) {
    confirmed = {
        true, "calibration drift confirmed: " + describe_drift(status),
        "drive on through surroundings with edges until infuse calibration shows a proposal, "
        "then sudo infuse apply, unless the policy applies it; check the camera mount"};
  }
  if (status.state == CalibrationState::kSuspected) {
    suspected = {true, "calibration drift suspected: " + describe_drift(status),
                 "drive through textured surroundings; see infuse calibration"};
  }
  if (status.state == CalibrationState::kRecalibrated) {
    changed = {true, "new calibration in use, on probation",
               "see infuse calibration; infuse rollback reverts it"};
  }
  conditions_.update({unusable, confirmed, fault, suspected, changed}, now);
  return conditions_;
}

}  // namespace infuse::daemon
