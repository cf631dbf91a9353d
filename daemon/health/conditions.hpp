#pragma once

#include <cstddef>
#include <initializer_list>
#include <string>
#include <vector>

#include "daemon/health/hysteresis.hpp"
#include "daemon/health/level.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// A problem of a sensor or a task.
struct Finding {
  const char* id = "";  ///< "silent", "undecodable", "no_sweeps", "loss", "clock", ...
  Level level = Level::kOk;
  Stamp since;         ///< when it was raised
  std::string what;    ///< description
  std::string advice;  ///< remedy
};

/// A finding that was raised or cleared at one tick.
struct Transition {
  bool raised = false;
  Finding finding;
};

/// Result of one check at one tick.
struct CheckResult {
  bool holds = false;
  std::string what = {};
  std::string advice = {};
};

/// Definition of a condition: its id, level and hysteresis.
struct ConditionDefinition {
  const char* id;
  Level level;
  Duration raise_after;
  Duration clear_after;
};

/// Conditions of one sensor or task: turns check results into findings and transitions.
class Conditions {
 public:
  /// `definitions` are ordered by level, the worst first.
  Conditions(std::initializer_list<ConditionDefinition> definitions);

  /// Updates each condition from its result; `results` is in the order of the definitions.
  void update(std::initializer_list<CheckResult> results, Stamp now);

  /// Findings raised at present, in the order of the definitions.
  const std::vector<Finding>& findings() const { return findings_; }
  /// Changes made by the last `update`.
  const std::vector<Transition>& transitions() const { return transitions_; }
  /// Level of the worst finding; kOk without one.
  Level level() const { return findings_.empty() ? Level::kOk : findings_.front().level; }

 private:
  struct Condition {
    const char* id;
    Level level;
    Hysteresis state;
    std::string what = {};
    std::string advice = {};

    Finding finding() const { return {id, level, state.raised_since(), what, advice}; }
  };

  std::vector<Condition> conditions_;
  std::vector<Finding> findings_;
  std::vector<Transition> transitions_;
};

}  // namespace infuse::daemon
