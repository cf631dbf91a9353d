#pragma once

#include <Eigen/Core>
#include <optional>

#include "daemon/health/conditions.hpp"
#include "daemon/health/health_options.hpp"
#include "drivers/measurement/stamp.hpp"
#include "fusion/streetmap/tracker.hpp"

namespace infuse::daemon {

/// Status of the street-map tracker at one moment of drive time. Plain data.
struct StreetMapStatus {
  streetmap::TrackState state = streetmap::TrackState::kLost;
  const char* reason = "";  ///< static text: why it is not TRACKING; empty if it is
  bool mismatch = false;    ///< observations do not match the map
  double x = 0;             ///< m, map frame
  double y = 0;             ///< m
  double sigma = 0;         ///< m, standard deviation of the position along the worst direction
  double elsewhere = 1;     ///< probability that the true place is another one that was checked
  double p_value = 1;       ///< probability of a match as good by chance
  double entropy = 1;       ///< normalised entropy of the particle weights, 0 … 1
  /// GNSS fixes minus the pose on the map, m east and north; nothing without fixes.
  std::optional<Eigen::Vector2d> gnss_offset{};
  double gnss_offset_sigma = 0;  ///< m
  uint32_t particles = 0;
  uint32_t hypotheses = 0;  ///< of the search on all streets; 0: there is none at present
  uint64_t updates = 0;     ///< of the particle weights
};

/// Checks the pose on the map, and the map itself. Pure.
class StreetMapHealth {
 public:
  explicit StreetMapHealth(const HealthOptions& options);

  /// Updates the findings; called about once a second. The result is valid until the next call.
  const Conditions& update(Stamp now, const StreetMapStatus& status);

 private:
  Conditions conditions_;
};

}  // namespace infuse::daemon
