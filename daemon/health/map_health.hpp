#pragma once

#include <cstdint>
#include <span>

#include "daemon/health/alert.hpp"
#include "drivers/measurement/stamp.hpp"
#include "fusion/places/localiser.hpp"

namespace infuse::daemon {

/// Status of the localisation on a map of keyframes at one moment of drive time. Plain data.
struct MapStatus {
  places::LocaliserState state = places::LocaliserState::kLost;
  const char* reason = "";  ///< static text: why it is not TRACKING; empty if it is
  double sigma = 0;         ///< m, standard deviation of the position along the worst direction
  places::PlaceProbabilities place;  ///< of the last search for the vehicle
  uint64_t verified = 0;             ///< places of the map that confirmed the pose
  uint64_t found = 0;                ///< times that the vehicle was found
  uint64_t dropped = 0;              ///< sweeps that came while the background thread was behind
};

/// The alerts of the pose on the map.
std::span<const Alert<MapStatus>> map_alerts();

}  // namespace infuse::daemon
