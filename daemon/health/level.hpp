#pragma once

#include <cstdint>

namespace infuse::daemon {

/// Health of a sensor or a task, in increasing severity.
enum class Level : uint8_t { kOk, kWarn, kError, kStale };

/// Returns "OK", "WARN", "ERROR" or "STALE".
constexpr const char* name_of(Level level) {
  switch (level) {
    case Level::kOk:
      return "OK";
    case Level::kWarn:
      return "WARN";
    case Level::kError:
      return "ERROR";
    case Level::kStale:
      return "STALE";
  }
  return "OK";
}

}  // namespace infuse::daemon
