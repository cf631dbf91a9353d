#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "daemon/health/alert.hpp"
#include "drivers/measurement/stamp.hpp"
#include "fusion/streetmap/tracker.hpp"

namespace infuse::daemon {

/// Status of the street-map tracker at one moment of drive time. Plain data.
struct StreetMapStatus {
  streetmap::TrackState state = streetmap::TrackState::kLost;
  const char* reason = "";        ///< static text: why it is not TRACKING; empty if it is
  bool mismatch = false;          ///< observations do not match the map
  bool on_map = false;            ///< x, y is a place on the map; false: outside, or there is none
  bool gnss_contradicts = false;  ///< fixes contradict the pose on the map
  double x = 0;                   ///< m, map frame
  double y = 0;                   ///< m
  double sigma = 0;      ///< m, standard deviation of the position along the worst direction
  double elsewhere = 1;  ///< probability that the true place is another one that was checked
  streetmap::PossiblePlaces places;  ///< where the vehicle may be; none while TRACKING
  double p_value = 1;                ///< probability of a match as good by chance
  double entropy = 1;                ///< normalised entropy of the particle weights, 0 … 1
  /// GNSS fixes minus the pose on the map, m east and north; nothing without fixes.
  std::optional<Eigen::Vector2d> gnss_offset{};
  double gnss_offset_sigma = 0;  ///< m
  uint32_t particles = 0;
  uint32_t hypotheses = 0;  ///< of the search on all streets; 0: there is none at present
  uint64_t updates = 0;     ///< of the particle weights
};

/// The alerts of the pose on the map, and of the map itself, the worst first.
std::span<const Alert<StreetMapStatus>> streetmap_alerts();

}  // namespace infuse::daemon
