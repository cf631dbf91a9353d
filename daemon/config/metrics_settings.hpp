#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace infuse::daemon {

/// Endpoint for Prometheus: the `[metrics]` table of the configuration.
struct MetricsSettings {
  std::string path;   ///< Unix stream socket; empty: none
  uint16_t port = 0;  ///< port on the loopback; 0: none

  /// True if metrics are served.
  bool enabled() const { return !path.empty() || port != 0; }

  /// Returns what is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const {
    if (!path.empty() && path.front() != '/') return "path must begin with /";
    return std::nullopt;
  }

  bool operator==(const MetricsSettings&) const = default;
};

}  // namespace infuse::daemon
