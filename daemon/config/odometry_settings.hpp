#pragma once

#include <optional>
#include <string>

#include "fusion/motion/odometry_options.hpp"

namespace infuse::daemon {

/// Settings of odometry: the `[odometry]` table of the configuration.
struct OdometrySettings {
  motion::OdometryOptions filter;
  bool use_gnss_speed = true;      ///< GNSS speed calibrates the wheel scale
  Duration max_wait{200'000'000};  ///< maximum drive time that a sweep waits for odometry, ns

  /// Returns what is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

}  // namespace infuse::daemon
