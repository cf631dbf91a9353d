#include "daemon/health/calibration_health.hpp"

namespace infuse::daemon {
namespace {

using monitoring::CalibrationState;
using CalibrationProblem = std::optional<Problem>;

bool has_fault(const CalibrationStatus& status) {
  return status.verdict.fault != monitoring::CameraFault::kNone;
}

constexpr Alert<CalibrationStatus> kCalibrationAlerts[] = {
    {{"calibration_unusable", Level::kError, Delays::kNone,
      "Three re-estimations in a row gave no usable result. Check the mount; calibrate again with "
      "`infuse calibrate`."},
     [](const CalibrationStatus& status) -> CalibrationProblem {
       if (has_fault(status) || status.state != CalibrationState::kUnusable) return {};
       return Problem{"calibration not usable: " + status.reason,
                      "check the camera mount; recalibrate with infuse calibrate"};
     }},
    {{"drift_confirmed", Level::kError, Delays::kNone,
      "The calibration has drifted. Drive on through surroundings with edges until `infuse "
      "calibration` shows a proposal, then `sudo infuse apply`, unless the policy applies it. "
      "Check the mount."},
     [](const CalibrationStatus& status) -> CalibrationProblem {
       if (status.state != CalibrationState::kConfirmed &&
           status.state != CalibrationState::kRecalibrating) {
         return {};
       }
       return Problem{
           "calibration drift confirmed: " + monitoring::describe_drift(status.verdict),
           "drive on through surroundings with edges until infuse calibration shows a proposal, "
           "then sudo infuse apply, unless the policy applies it; check the camera mount"};
     }},
    {{"camera_fault", Level::kError, Delays::kNone,
      "The camera is black, frozen, dirty, out of focus or late, or its images are those of "
      "another camera of the rig. Check camera, lens, cable and device; the calibration is left "
      "unchanged."},
     [](const CalibrationStatus& status) -> CalibrationProblem {
       if (!has_fault(status)) return {};
       return Problem{"camera fault: " + monitoring::describe_fault(status.verdict),
                      "check the camera, its lens, its cable and its device; the calibration is "
                      "left unchanged"};
     }},
    {{"drift_suspected", Level::kWarn, Delays::kNone,
      "Evidence for a drift, not enough yet. Drive through textured surroundings."},
     [](const CalibrationStatus& status) -> CalibrationProblem {
       if (status.state != CalibrationState::kSuspected) return {};
       return Problem{"calibration drift suspected: " + monitoring::describe_drift(status.verdict),
                      "drive through textured surroundings; see infuse calibration"};
     }},
    {{"calibration_changed", Level::kWarn, Delays::kNone,
      "A new calibration is in use, on probation. `infuse rollback` reverts it."},
     [](const CalibrationStatus& status) -> CalibrationProblem {
       if (status.state != CalibrationState::kRecalibrated) return {};
       return Problem{"new calibration in use, on probation",
                      "see infuse calibration; infuse rollback reverts it"};
     }},
};

}  // namespace

std::span<const Alert<CalibrationStatus>> calibration_alerts() { return kCalibrationAlerts; }

}  // namespace infuse::daemon
