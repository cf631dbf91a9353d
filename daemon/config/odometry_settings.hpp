#pragma once

#include <optional>
#include <string>

#include "fusion/motion/odometry_options.hpp"

namespace infuse::daemon {

/// Settings of odometry: the `[odometry]` table of the configuration.
struct OdometrySettings {
  motion::OdometryOptions filter;
  bool use_gnss_speed = true;       ///< a GNSS receiver measures speed and changes of the heading
  std::optional<bool> use_lidar;    ///< the first lidar measures the motion; nothing: where its
                                    ///< mounting is known or nothing else measures it
  std::optional<bool> planar;       ///< replaces `filter.planar`; nothing: where neither the lidar
                                    ///< nor three gyros measure the motion
  double max_heading_sigma = 0.35;  ///< rad; a pose in the frame `odom` is usable up to it
  Duration max_wait{200'000'000};   ///< maximum drive time that a sweep waits for odometry, ns

  /// Returns what is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

}  // namespace infuse::daemon
