#pragma once

#include <cstddef>
#include <cstdint>

namespace infuse::monitoring {

/// State of a calibration.
enum class CalibrationState : uint8_t {
  kOk,
  kMonitoring,     ///< too few evaluations so far
  kSuspected,      ///< evidence for a drift, below the confirmation threshold
  kConfirmed,      ///< drift; a re-estimation waits for scenes, or its result for the owner
  kRecalibrating,  ///< a re-estimation runs
  kRecalibrated,   ///< a new calibration is in use and on probation
  kUnusable,       ///< the camera has a fault, or re-estimations keep failing: do not use it
};
inline constexpr size_t kCalibrationStates = static_cast<size_t>(CalibrationState::kUnusable) + 1;

/// "OK", "MONITORING" …
const char* name_of(CalibrationState state);

/// Use of a re-estimated calibration.
enum class UpdatePolicy : uint8_t {
  kAlertOnly,    ///< proposed; the owner applies it
  kApply,        ///< applied
  kApplyWithin,  ///< applied if it moved by less than the limits, otherwise proposed
};

/// What can happen to a calibration.
enum class CalibrationEvent : uint8_t {
  // What an image says of the calibration in use:
  kLearning,   ///< too few evaluations so far
  kHolds,      ///< no evidence for a drift
  kDoubted,    ///< some evidence, too little for a suspicion
  kSuspected,  ///< `Drift::kSuspected`
  kConfirmed,  ///< `Drift::kConfirmed`
  kFault,      ///< nothing: the camera has a fault
  kGivenUp,    ///< nothing that counts: re-estimations have failed too often
  // Probation of a new calibration:
  kProbationPassed,
  kProbationFailed,  ///< following scenes fit the one before better
  // Re-estimation:
  kScenesReady,       ///< one is wanted and has enough scenes
  kResultFailed,      ///< without a usable result
  kResultFailedLast,  ///< the same, the last that is tried
  kResultUnmoved,     ///< the calibration in use is right
  kResultAllowed,     ///< a new calibration that the policy applies
  kResultProposed,    ///< a new calibration that waits for the owner
  // What an image says of the calibration that waits for the owner:
  kProposalOutdated,  ///< it has drifted too
  // Requests of the owner:
  kOwnerRecalibrates,
  kOwnerApplies,
  kOwnerRollsBack,
  kOwnerFreezes,
};
inline constexpr size_t kCalibrationEvents =
    static_cast<size_t>(CalibrationEvent::kOwnerFreezes) + 1;

/// What a transition does, as bits.
enum CalibrationActions : uint16_t {
  kNothing = 0,
  kStart = 1 << 0,            ///< start the re-estimation
  kCancel = 1 << 1,           ///< cancel the running one; its result is not used
  kUse = 1 << 2,              ///< put the calibration of the event into use
  kRevert = 1 << 3,           ///< put the one before the probation into use
  kPropose = 1 << 4,          ///< keep the calibration of the event for the owner
  kWithdraw = 1 << 5,         ///< drop the calibration that waits for the owner
  kRestartEvidence = 1 << 6,  ///< what was observed so far no longer counts
  kForgetFailures = 1 << 7,   ///< re-estimations are tried again
  kWant = 1 << 8,             ///< start a re-estimation as soon as there are scenes
  kNote = 1 << 9,             ///< an entry in the history
};

/// Result of an event in a state.
struct CalibrationTransition {
  CalibrationState state = CalibrationState::kOk;
  uint16_t actions = kNothing;  ///< `CalibrationActions`

  bool does(CalibrationActions action) const { return (actions & action) != 0; }
};

/// The state machine of a calibration, a table: every event in every state.
CalibrationTransition transition(CalibrationState state, CalibrationEvent event);

}  // namespace infuse::monitoring
