#pragma once

#include "daemon/health/conditions.hpp"
#include "daemon/health/health_options.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// What the street-map tracker says of itself, at one moment of drive time. Plain data.
struct StreetMapStatus {
  const char* state = "";   ///< "TRACKING", "UNSURE" or "LOST"; empty: there is no map
  const char* reason = "";  ///< static text: why it is not sure; empty where it is
  bool mismatch = false;    ///< what is seen does not fit the map
  double x = 0;             ///< m, map frame
  double y = 0;             ///< m
  double p_value = 1;       ///< chance that the fit is chance
  double entropy = 1;       ///< of the particles' weights, 0 … 1
  int particles = 0;
  uint64_t updates = 0;

  bool present() const { return *state != '\0'; }
};

/// Judges whether the vehicle knows its place on the map, and whether the map is right. Pure.
class StreetMapHealth {
 public:
  explicit StreetMapHealth(const HealthOptions& options);

  /// About one call a second. The answer is valid until the next call.
  const Conditions& update(Stamp now, const StreetMapStatus& figures);

 private:
  Conditions conditions_;
};

}  // namespace infuse::daemon
