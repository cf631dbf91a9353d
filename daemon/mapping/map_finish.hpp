#pragma once

#include <functional>
#include <map>
#include <string>

#include "daemon/mapping/map_folder.hpp"
#include "daemon/mapping/map_settings.hpp"

namespace infuse::daemon {

/// What is printed about a map.
struct MapSummary {
  size_t drives = 1;
  size_t keyframes = 0;
  size_t clouds = 0;  ///< of keyframes, that are kept
  uint64_t sweeps = 0;
  uint64_t unregistered = 0;               ///< sweeps whose motion the lidar did not measure …
  uint64_t unmeasured = 0;                 ///< … and no other sensor either
  double way = 0;                          ///< m
  size_t closures = 0;                     ///< accepted
  std::map<std::string, size_t> rejected;  ///< closures by reason
  double cost_before = 0, cost = 0;        ///< chi-squared of odometry and accepted closures
  double moved = 0;  ///< m, root mean square by which the closures moved the keyframes
  bool georeferenced = false;
  size_t fixes = 0, fixes_rejected = 0;
  double tilt_sigma = 0;        ///< rad, of the map's vertical where it is known least
  double fix_rms = 0;           ///< m, horizontal, of the accepted fixes
  std::string position_reason;  ///< why it is not georeferenced
  std::string reason;           ///< why the map is not usable; empty if it is

  bool usable() const { return reason.empty(); }
};

MapJson to_json(const MapSummary& summary);
std::string to_text(const MapSummary& summary);

/// Called with the number of keyframes searched so far and of all, and closures accepted.
using MapProgress = std::function<void(size_t done, size_t all, size_t closures)>;

/// Joins the drives of a merged map by the places that they share, seeks the closures of the
/// replayed drives, optimises their graph, fits it to its fixes and writes the rest of the map,
/// map.json last. Closures that an interrupted run left in closures.csv are not verified again. The
/// bytes depend on the drive and the settings alone.
Result<MapSummary> finish_map(const MapFolder& folder, const MapDrive& drive,
                              const MapSettings& settings, const MapProgress& progress);

}  // namespace infuse::daemon
