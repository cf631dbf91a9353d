#pragma once

#include <cmath>
#include <cstdlib>
#include <type_traits>

/// Only in the copy of the sources that `./dev prove sensitivity` compiles: each constant is read
/// through tuned(), which multiplies the one that the environment names. INFUSE_TUNED is "NUMBER
/// FACTOR".
namespace infuse {

struct Tuning {
  long number = -1;
  double factor = 1;
};

inline const Tuning& tuning() {
  static const Tuning found = [] {
    Tuning tuning;
    if (const char* text = std::getenv("INFUSE_TUNED")) {
      char* end = nullptr;
      tuning.number = std::strtol(text, &end, 10);
      tuning.factor = std::strtod(end, nullptr);
    }
    return tuning;
  }();
  return found;
}

/// A whole number is rounded: 1 halved stays 1.
template <class T>
T tuned(long number, T value) {
  const Tuning& now = tuning();
  if (number != now.number) return value;
  if constexpr (std::is_integral_v<T>) {
    return static_cast<T>(std::llround(static_cast<double>(value) * now.factor));
  } else if constexpr (std::is_floating_point_v<T>) {
    return static_cast<T>(value * now.factor);
  } else {
    return T(static_cast<typename T::rep>(static_cast<double>(value.count()) * now.factor));
  }
}

}  // namespace infuse
