#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/health/alert.hpp"
#include "daemon/health/health_options.hpp"
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

/// Returns the finding of an alert that is raised since a time.
Finding make_finding(const AlertDescription& alert, Stamp since, const Problem& problem);

/// Returns the level of the worst finding; kOk without one.
Level worst_level(const std::vector<Finding>& findings);

/// A finding that was raised or cleared at one tick.
struct Transition {
  bool raised = false;
  Finding finding;
};

/// One alert over time: its hysteresis, and the latest problem.
class Condition {
 public:
  /// `alert` outlives it.
  Condition(const AlertDescription& alert, const HealthOptions& options);

  /// Updates it from the result of its check. Returns true if it was raised or cleared.
  bool update(std::optional<Problem> problem, Stamp now);

  bool raised() const { return state_.raised(); }
  Finding finding() const { return make_finding(*alert_, state_.raised_since(), problem_); }

 private:
  const AlertDescription* alert_;
  Hysteresis state_;
  Problem problem_;  // the latest
};

}  // namespace infuse::daemon
