#include "daemon/health/conditions.hpp"

namespace infuse::daemon {

Conditions::Conditions(std::initializer_list<ConditionDefinition> definitions) {
  for (const ConditionDefinition& definition : definitions) {
    conditions_.push_back(
        {definition.id, definition.level, {definition.raise_after, definition.clear_after}});
  }
}

void Conditions::update(std::initializer_list<CheckResult> results, Stamp now) {
  transitions_.clear();
  findings_.clear();
  const CheckResult* result = results.begin();
  for (Condition& condition : conditions_) {
    const bool was = condition.state.raised();
    if (result->holds) {
      condition.what = result->what;
      condition.advice = result->advice;
    }
    const bool is = condition.state.update(result->holds, now);
    if (was != is) transitions_.push_back({is, condition.finding()});
    if (is) findings_.push_back(condition.finding());
    ++result;
  }
}

}  // namespace infuse::daemon
