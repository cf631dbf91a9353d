#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace infuse::daemon {

/// Where Prometheus may look. The `[metrics]` table of the configuration.
struct MetricsSettings {
  std::string path;   ///< Unix stream socket; empty: none
  uint16_t port = 0;  ///< on the loopback; 0: none

  /// Somebody may look.
  bool enabled() const { return !path.empty() || port != 0; }

  /// What is wrong, or nothing.
  std::optional<std::string> invalid() const {
    if (!path.empty() && path.front() != '/') return "path must begin with /";
    return std::nullopt;
  }

  bool operator==(const MetricsSettings&) const = default;
};

}  // namespace infuse::daemon
