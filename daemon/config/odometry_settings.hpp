#pragma once

#include <optional>
#include <string>

#include "fusion/motion/odometry_options.hpp"

namespace infuse::daemon {

/// Settings of odometry: the `[odometry]` table of the configuration.
struct OdometrySettings {
  motion::OdometryOptions filter;
  bool use_gnss_speed = true;      ///< a GNSS receiver measures speed and changes of the heading
  std::optional<bool> use_lidar;   ///< the first lidar measures the motion; nothing: where no bus
                                   ///< and no inertial unit does
  std::optional<bool> planar;      ///< replaces `filter.planar`; nothing: planar without the lidar
  Duration max_wait{200'000'000};  ///< maximum drive time that a sweep waits for odometry, ns

  /// Returns what is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

}  // namespace infuse::daemon
