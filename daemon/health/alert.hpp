#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "daemon/health/level.hpp"

namespace infuse::daemon {

/// What a check found wrong at one tick.
struct Problem {
  std::string what;    ///< description
  std::string advice;  ///< remedy
};

/// Delays of an alert: those of the `[health]` table of the configuration, or none.
enum class Delays : uint8_t {
  kNone,      ///< raised and cleared at once
  kClearing,  ///< raised at once, cleared after `clear_after`
  kBoth,      ///< raised after `raise_after`, cleared after `clear_after`
};

/// Description of an alert: what does not depend on the moment.
struct AlertDescription {
  const char* id;     ///< "silent"; an ALERT report puts the device before it
  Level level;        ///< while it is raised
  Delays delays;      ///< of raising and clearing
  const char* about;  ///< entry of infused(8): condition and remedy; `…` encloses what is typed
  bool in_health = true;  ///< HEALTH lists it while it is raised
};

/// An alert and the check that raises it. This is all that there is to say about an alert:
/// docs/CONTRIBUTING.md, "An alert". `Input`: what is known about the sensor or task at one tick.
template <class Input>
struct Alert {
  AlertDescription description;
  /// Returns what is wrong; nothing if the condition does not hold.
  std::optional<Problem> (*check)(const Input& input);
};

}  // namespace infuse::daemon
