#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

namespace infuse::daemon {

// Building blocks of `descriptions.hpp`. A report is described by a function
//
//     template <class Visitor> void describe(Visitor& v, const Report& report)
//
// that calls `v.message(class, text)` for a message, and then for every field
// `v.field(name, value, text, metric)`. The JSON encoder, the JSON Schema and the metrics are
// visitors. The type of the value determines its type on the wire; `std::optional`: absent if
// empty.

/// Metric that exports a field.
struct Metric {
  const char* name = nullptr;  ///< null: not exported
  const char* type = "gauge";
  double scale = 1;            ///< to the unit of the name
  const char* label = "";      ///< additional label: cause="network"
  const char* help = nullptr;  ///< null: the text of the field
};

/// A metric that only grows; its name ends in _total.
constexpr Metric counter(const char* name, const char* label = "", const char* help = nullptr) {
  return {name, "counter", 1, label, help};
}

/// A metric of a momentary value.
constexpr Metric gauge(const char* name, double scale = 1) { return {name, "gauge", scale}; }

/// A number ≥ kMin, and ≤ kMax unless that is less.
template <class T, int kMin, int kMax = -1>
struct Limited {
  T value{};
};

/// A number ≥ 0.
inline Limited<double, 0> non_negative(double value) { return {value}; }
/// A number in 0 … 1.
inline Limited<double, 0, 1> fraction(double value) { return {value}; }
/// A count ≥ 1.
inline Limited<uint64_t, 1> positive(uint64_t value) { return {value}; }

/// A text out of the set `kChoices`.
template <const auto& kChoices>
struct Choice {
  std::string_view value;
};

/// Rounds to three decimals: enough for rates and milliseconds.
inline double rounded(double value) { return std::round(value * 1000) / 1000; }

/// Returns the value if `holds`, else nothing.
template <class T>
std::optional<T> when(bool holds, T value) {
  return holds ? std::optional<T>(std::move(value)) : std::nullopt;
}

/// Returns the text unless it is empty.
inline std::optional<std::string_view> unless_empty(std::string_view text) {
  return when(!text.empty(), text);
}

}  // namespace infuse::daemon
