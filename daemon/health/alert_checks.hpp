#pragma once

#include <optional>
#include <span>
#include <vector>

#include "daemon/health/alert.hpp"
#include "daemon/health/conditions.hpp"

namespace infuse::daemon {

/// Checks the alerts of one sensor or task: turns what is known at each tick into findings and
/// transitions. Pure; `Input` as in `Alert`.
template <class Input>
class AlertChecks {
 public:
  /// `alerts` outlive this; their order, the worst first, is that of the findings.
  AlertChecks(std::span<const Alert<Input>> alerts, const HealthOptions& options) {
    for (const Alert<Input>& alert : alerts) {
      checks_.push_back({alert.check, Condition(alert.description, options)});
    }
  }

  /// Runs every check; called in order of time. Returns itself.
  const AlertChecks& update(Stamp now, const Input& input) {
    transitions_.clear();
    findings_.clear();
    for (auto& [check, condition] : checks_) {
      const bool changed = condition.update(check(input), now);
      if (changed) transitions_.push_back({condition.raised(), condition.finding()});
      if (condition.raised()) findings_.push_back(condition.finding());
    }
    return *this;
  }

  /// Findings raised at present, in the order of the alerts.
  const std::vector<Finding>& findings() const { return findings_; }
  /// Changes made by the last `update`.
  const std::vector<Transition>& transitions() const { return transitions_; }
  /// Level of the worst finding; kOk without one.
  Level level() const { return worst_level(findings_); }

 private:
  struct Check {
    std::optional<Problem> (*check)(const Input&);
    Condition condition;
  };

  std::vector<Check> checks_;
  std::vector<Finding> findings_;
  std::vector<Transition> transitions_;
};

}  // namespace infuse::daemon
