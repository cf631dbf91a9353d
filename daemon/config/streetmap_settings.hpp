#pragma once

#include <optional>
#include <string>

#include "fusion/streetmap/tracker_options.hpp"

namespace infuse::daemon {

/// Where the vehicle begins on the street map, map frame.
struct InitialPose {
  double x = 0;    ///< m east of the map's origin
  double y = 0;    ///< m north
  double yaw = 0;  ///< rad, counter-clockwise from east
};

/// What the owner can say of the street map. The `[streetmap]` table of the configuration.
struct StreetMapSettings {
  std::string map;                            ///< file of `infuse streetmap`; empty: no tracking
  std::optional<InitialPose> initial_pose{};  ///< nothing: a satellite receiver tells
  double initial_sigma = 2;                   ///< m, how exactly the start is known
  double initial_yaw_sigma = 0.09;            ///< rad, the same
  double update_hz = 2;  ///< times a second of drive time that particles are weighed
  streetmap::TrackerOptions tracker;

  /// What is wrong with the numbers, or nothing.
  std::optional<std::string> invalid() const;
};

}  // namespace infuse::daemon
