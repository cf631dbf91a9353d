#include "daemon/health/conditions.hpp"

#include <algorithm>

namespace infuse::daemon {
namespace {

Hysteresis hysteresis_of(Delays delays, const HealthOptions& options) {
  return {delays == Delays::kBoth ? options.raise_after : Duration::zero(),
          delays == Delays::kNone ? Duration::zero() : options.clear_after};
}

}  // namespace

Finding make_finding(const AlertDescription& alert, Stamp since, const Problem& problem) {
  return {alert.id, alert.level, since, problem.what, problem.advice};
}

Level worst_level(const std::vector<Finding>& findings) {
  Level worst = Level::kOk;
  for (const Finding& finding : findings) worst = std::max(worst, finding.level);
  return worst;
}

Condition::Condition(const AlertDescription& alert, const HealthOptions& options)
    : alert_(&alert), state_(hysteresis_of(alert.delays, options)) {}

bool Condition::update(std::optional<Problem> problem, Stamp now) {
  const bool was = state_.raised();
  const bool holds = problem.has_value();
  if (holds) problem_ = *std::move(problem);
  return state_.update(holds, now) != was;
}

}  // namespace infuse::daemon
