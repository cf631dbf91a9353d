#include "daemon/health/conditions.hpp"

namespace infuse::daemon {

Conditions::Conditions(std::initializer_list<ConditionDefinition> definitions) {
  for (const ConditionDefinition& definition : definitions) {
    conditions_.push_back(
        {definition.id, definition.level, {definition.raise_after, definition.clear_after}});
  }
}

void Conditions::judge(std::initializer_list<Verdict> verdicts, Stamp now) {
  transitions_.clear();
  findings_.clear();
  const Verdict* verdict = verdicts.begin();
  for (Condition& condition : conditions_) {
    const bool was = condition.state.raised();
    if (verdict->holds) {
      condition.what = verdict->what;
      condition.advice = verdict->advice;
    }
    const bool is = condition.state.update(verdict->holds, now);
    if (was != is) transitions_.push_back({is, condition.finding()});
    if (is) findings_.push_back(condition.finding());
    ++verdict;
  }
}

}  // namespace infuse::daemon
