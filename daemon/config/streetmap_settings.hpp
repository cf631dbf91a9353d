#pragma once

#include <optional>
#include <string>

#include "fusion/streetmap/planar_pose.hpp"
#include "fusion/streetmap/segment_map.hpp"
#include "fusion/streetmap/tracker_options.hpp"

namespace infuse::daemon {

/// Initial pose on the street map, map frame.
struct InitialPose {
  double x = 0;                 ///< m east of the map's origin
  double y = 0;                 ///< m north
  std::optional<double> yaw{};  ///< rad, counter-clockwise from east; nothing: unknown
};

/// Initial pose by the earth: for a map that has latitude and longitude.
struct InitialLocation {
  double latitude = 0;              ///< rad, WGS 84
  double longitude = 0;             ///< rad
  std::optional<double> heading{};  ///< rad, clockwise from north; nothing: unknown
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

/// The start that the settings state, map frame; nothing if they state none, or the map has no
/// latitude and longitude for it. An unknown heading has the standard deviation of all headings.
struct StatedStart {
  streetmap::PlanarPose pose;
  double yaw_sigma = 0;  ///< rad
};
std::optional<StatedStart> stated_start(const StreetMapSettings& settings,
                                        const streetmap::MapFrame& frame);

}  // namespace infuse::daemon
