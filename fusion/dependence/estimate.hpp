#pragma once

namespace infuse::dependence {

/// What an estimator answers: a value, and whether it may be used. `value` is always finite.
struct Estimate {
  double value = 0;         ///< nats, or the measure's own unit
  const char* reason = "";  ///< static text: why the value cannot be used; empty when it can

  bool usable() const { return *reason == '\0'; }
};

}  // namespace infuse::dependence
