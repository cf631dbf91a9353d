#pragma once

#include <optional>
#include <string>

#include "fusion/motion/odometry_options.hpp"

namespace infuse::daemon {

/// What the owner can say of the vehicle. The `[odometry]` table of the configuration.
struct OdometrySettings {
  motion::OdometryOptions filter;
  bool use_gnss_speed = true;      ///< a receiver's speed tells the wheels' scale
  Duration max_wait{200'000'000};  ///< ns of drive time that a sweep waits for odometry

  /// What is wrong with the numbers, or nothing.
  std::optional<std::string> invalid() const;
};

}  // namespace infuse::daemon
