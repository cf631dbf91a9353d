#pragma once

#include <cstddef>
#include <initializer_list>
#include <string>
#include <vector>

#include "daemon/health/hysteresis.hpp"
#include "daemon/health/level.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// One thing that is wrong.
struct Finding {
  const char* id = "";  ///< "silent", "undecodable", "no_sweeps", "loss", "clock", ...
  Level level = Level::kOk;
  Stamp since;         ///< when it was raised
  std::string what;    ///< a sentence
  std::string advice;  ///< what to do
};

/// A finding that appeared or went away at one tick.
struct Transition {
  bool raised = false;
  Finding finding;
};

/// Whether one condition holds at one tick, and the words for it.
struct CheckResult {
  bool holds = false;
  std::string what = {};
  std::string advice = {};
};

/// A condition that can be judged.
struct ConditionDefinition {
  const char* id;
  Level level;
  Duration raise_after;
  Duration clear_after;
};

/// The conditions of one sensor or one task: verdicts in, findings and transitions out.
class Conditions {
 public:
  /// The worst first.
  Conditions(std::initializer_list<ConditionDefinition> definitions);

  /// Takes a verdict for each condition, in the order of the definitions.
  void update(std::initializer_list<CheckResult> results, Stamp now);

  /// What is wrong now, in the order of the definitions.
  const std::vector<Finding>& findings() const { return findings_; }
  /// What the last `judge` changed.
  const std::vector<Transition>& transitions() const { return transitions_; }
  /// Of the first finding.
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
