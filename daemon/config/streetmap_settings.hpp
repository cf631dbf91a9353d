#pragma once

#include <optional>
#include <string>

#include "fusion/streetmap/tracker_options.hpp"

namespace infuse::daemon {

/// Initial pose on the street map, map frame.
struct InitialPose {
  double x = 0;    ///< m east of the map's origin
  double y = 0;    ///< m north
  double yaw = 0;  ///< rad, counter-clockwise from east
};

/// Initial pose by the earth: for a map that has latitude and longitude.
struct InitialLocation {
  double latitude = 0;   ///< rad, WGS 84
  double longitude = 0;  ///< rad
  double heading = 0;    ///< rad, clockwise from north
};

/// Settings of the street map: the `[streetmap]` table of the configuration.
struct StreetMapSettings {
  std::string map;                            ///< file of `infuse streetmap`; empty: no tracking
  std::optional<InitialPose> initial_pose{};  ///< nothing: the location, or GNSS fixes
  std::optional<InitialLocation> initial_location{};  ///< nothing: the pose, or GNSS fixes
  double initial_sigma = 2;         ///< m, standard deviation of the initial position
  double initial_yaw_sigma = 0.09;  ///< rad, standard deviation of the initial yaw
  bool require_tracking = true;     ///< false: a pose that is UNSURE is usable too
  double update_hz = 2;             ///< rate of particle weighting, in drive time
  streetmap::TrackerOptions tracker;

  /// Returns what is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

}  // namespace infuse::daemon
