#pragma once

namespace infuse::dependence {

/// Value of an estimator, with the reason if it is unusable. `value` is always finite.
struct Estimate {
  double value = 0;         ///< nats, or the unit of the measure
  const char* reason = "";  ///< static text: why the value is unusable; empty if usable

  bool usable() const { return *reason == '\0'; }  ///< it may be used
};

}  // namespace infuse::dependence
