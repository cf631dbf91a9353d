#include "fusion/monitoring/calibration_states.hpp"

#include <array>
#include <optional>

namespace infuse::monitoring {
namespace {

using State = CalibrationState;
using Event = CalibrationEvent;

/// Set of states, as bits.
constexpr int in(State state) { return 1 << static_cast<int>(state); }
constexpr int kOk = in(State::kOk), kMonitoring = in(State::kMonitoring),
              kSuspected = in(State::kSuspected), kConfirmed = in(State::kConfirmed),
              kRecalibrating = in(State::kRecalibrating), kRecalibrated = in(State::kRecalibrated),
              kUnusable = in(State::kUnusable);
constexpr int kAny = (1 << kCalibrationStates) - 1;
/// States that follow what the images say. A re-estimation ends by its result, a probation by its
/// evaluations, and both by a fault of the camera or by the owner.
constexpr int kFollowing = kOk | kMonitoring | kSuspected | kConfirmed | kUnusable;

constexpr std::nullopt_t kSame = std::nullopt;

struct Rule {
  Event event;
  int states;
  std::optional<State> next;
  int actions = kNothing;
};

constexpr int kReplace = kUse | kCancel | kWithdraw | kForgetFailures | kNote;

// What is not listed changes nothing.
constexpr Rule kRules[] = {
    {Event::kLearning, kFollowing, State::kMonitoring},
    {Event::kHolds, kFollowing & ~kConfirmed, State::kOk},
    {Event::kHolds, kConfirmed, State::kOk, kWithdraw},
    {Event::kDoubted, kMonitoring | kUnusable, State::kOk},
    {Event::kSuspected, kFollowing & ~kConfirmed, State::kSuspected},
    {Event::kConfirmed, kFollowing & ~kConfirmed, State::kConfirmed, kNote},
    {Event::kFault, kAny & ~kRecalibrating & ~kUnusable, State::kUnusable, kNote},
    {Event::kFault, kRecalibrating, State::kUnusable, kCancel | kNote},

    {Event::kProbationPassed, kRecalibrated, State::kOk, kNote},
    {Event::kProbationFailed, kRecalibrated, State::kSuspected, kRevert | kNote},

    // The evidence of the same image decides what follows MONITORING.
    {Event::kScenesReady, kFollowing & ~kUnusable, State::kRecalibrating, kStart},
    {Event::kResultFailed, kRecalibrating, State::kMonitoring, kNote},
    {Event::kResultFailedLast, kRecalibrating, State::kUnusable, kNote},
    {Event::kResultUnmoved, kRecalibrating, State::kOk,
     kRestartEvidence | kForgetFailures | kWithdraw | kNote},
    {Event::kResultAllowed, kRecalibrating, State::kRecalibrated,
     kUse | kForgetFailures | kWithdraw | kNote},
    {Event::kResultProposed, kRecalibrating, State::kMonitoring,
     kPropose | kForgetFailures | kNote},

    {Event::kProposalOutdated, kAny & ~kRecalibrated, kSame, kWithdraw | kNote},

    {Event::kOwnerRecalibrates, kAny & ~kRecalibrating & ~kUnusable, kSame, kWant},
    {Event::kOwnerRecalibrates, kUnusable, kSame, kWant | kForgetFailures},
    {Event::kOwnerApplies, kAny, State::kRecalibrated, kReplace},
    {Event::kOwnerRollsBack, kAny, State::kMonitoring, kReplace},
    {Event::kOwnerFreezes, kRecalibrating, State::kMonitoring, kCancel},
    {Event::kOwnerFreezes, kRecalibrated, State::kMonitoring},
};

using Table = std::array<std::array<CalibrationTransition, kCalibrationStates>, kCalibrationEvents>;

constexpr Table make_table() {
  Table table{};
  for (size_t event = 0; event < kCalibrationEvents; ++event) {
    for (size_t state = 0; state < kCalibrationStates; ++state) {
      table[event][state] = {static_cast<State>(state), kNothing};
    }
  }
  for (size_t state = 0; state < kCalibrationStates; ++state) {
    const int bit = in(static_cast<State>(state));
    for (const Rule& rule : kRules) {
      if ((rule.states & bit) == 0) continue;
      CalibrationTransition& cell = table[static_cast<size_t>(rule.event)][state];
      cell = {rule.next.value_or(cell.state), static_cast<uint16_t>(rule.actions)};
    }
  }
  return table;
}

constexpr Table kTable = make_table();

}  // namespace

const char* name_of(CalibrationState state) {
  constexpr std::array<const char*, kCalibrationStates> kNames = {
      "OK", "MONITORING", "SUSPECTED", "CONFIRMED", "RECALIBRATING", "RECALIBRATED", "UNUSABLE"};
  return kNames[static_cast<size_t>(state)];
}

CalibrationTransition transition(CalibrationState state, CalibrationEvent event) {
  return kTable[static_cast<size_t>(event)][static_cast<size_t>(state)];
}

}  // namespace infuse::monitoring
