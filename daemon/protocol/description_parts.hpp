#pragma once

#include <cmath>
#include <optional>

#include "daemon/protocol/field.hpp"
#include "daemon/protocol/names.hpp"
#include "daemon/protocol/reports.hpp"
#include "drivers/measurement/angles.hpp"

namespace infuse::daemon {

// What the descriptions of several messages use (`descriptions.hpp`).

/// Text of the field `stamp`.
inline constexpr const char* kStampText = "ns since the Unix epoch; drive time in a replay";
/// Text of a covariance of a pose.
inline constexpr const char* kCovarianceText =
    "by row; rx ry rz tx ty tz, rad and m, left perturbation in the target frame";

/// Converts radians to degrees, for the wire.
inline double degrees(double radians) { return radians / kDegree; }

/// Returns the value if it is finite, else nothing.
template <class Number>
std::optional<Number> finite(Number number) {
  return when(std::isfinite(number.value), number);
}

/// A stamp in seconds, for metrics.
constexpr Metric stamp_gauge(const char* name) { return gauge(name, 1e-9); }

template <class Visitor>
void describe(Visitor& v, const Finding& finding) {
  v.field("id", finding.id);
  v.field("level", finding.level);
  v.field("since", finding.since, "stamp, ns");
  v.field("what", finding.what);
  v.field("advice", finding.advice, "what to do");
}

}  // namespace infuse::daemon
