#include "daemon/health/calibration_health.hpp"

#include <spdlog/fmt/fmt.h>

namespace infuse::daemon {
namespace {

/// "seems to have turned: rotation about y, +0.52 ± 0.03 ° (evidence 20 of 17 nats)".
std::string movement(const CalibrationFigures& figures) {
  return fmt::format("{}, by {:+.2f} ± {:.2f} {} (evidence {:.1f} of {:.1f} nats)", figures.axis,
                     figures.offset, figures.deviation, figures.unit, figures.evidence,
                     figures.evidence_needed);
}

}  // namespace

CalibrationHealth::CalibrationHealth()
    : conditions_{{"calibration_unusable", Level::kError, Duration::zero(), Duration::zero()},
                  {"calibration_drifted", Level::kError, Duration::zero(), Duration::zero()},
                  {"camera_fault", Level::kError, Duration::zero(), Duration::zero()},
                  {"calibration_suspect", Level::kWarn, Duration::zero(), Duration::zero()},
                  {"calibration_changed", Level::kWarn, Duration::zero(), Duration::zero()}} {}

const Conditions& CalibrationHealth::update(Stamp now, const CalibrationFigures& figures) {
  Verdict unusable, drifted, fault, suspect, changed;
  if (!figures.fault.empty()) {
    fault = {true, "the camera is at fault: " + figures.fault,
             "look at the camera, its lens and its cable; its calibration is left alone meanwhile"};
  } else if (figures.state == "UNUSABLE") {
    unusable = {true, "the calibration must not be used: " + figures.reason,
                "look at the camera's mount; calibrate anew with infuse calibrate"};
  }
  if (figures.state == "DRIFTED" || figures.state == "RECALIBRATING") {
    drifted = {true, "the calibration has drifted: " + movement(figures),
               "look at the camera's mount; see infuse calibration, then infuse apply"};
  }
  if (figures.state == "SUSPECT") {
    suspect = {true, "the calibration may have drifted: " + movement(figures),
               "drive on through places with texture; see infuse calibration"};
  }
  if (figures.state == "RECALIBRATED") {
    changed = {true, "a new calibration is in use, on probation",
               "see infuse calibration; infuse rollback takes it back"};
  }
  conditions_.judge({unusable, drifted, fault, suspect, changed}, now);
  return conditions_;
}

}  // namespace infuse::daemon
