#pragma once

#include <optional>
#include <string>

namespace infuse::daemon {

/// Settings of the localisation on a map of keyframes: the `[map]` table of the configuration.
struct MapLocationSettings {
  std::string directory;  ///< folder of `infuse map`; empty: none
  std::string lidar;      ///< whose sweeps are compared with it; empty: the first

  /// Returns what is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const {
    if (directory.empty() && !lidar.empty()) return "a lidar without a directory";
    return std::nullopt;
  }
};

}  // namespace infuse::daemon
