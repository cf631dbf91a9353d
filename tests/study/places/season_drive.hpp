#pragma once

#include <string>
#include <vector>

#include "fixtures/simulator/simulation.hpp"
#include "tests/study/registration/posed_scan.hpp"

namespace infuse::study {

/// What a street looks like at one visit.
struct Visit {
  const char* name;
  simulator::SeasonOptions season;
  simulator::AirOptions air;
  simulator::LightOptions light;
  double parked_cars = 0.5;
  uint64_t seed = 0;      ///< of cars, traffic, noise
  bool reversed = false;  ///< drives the other way
};

/// The map's visit first: winter without snow, overcast; then the same with other cars, as a
/// control; then summer, autumn, snow, night. They were fixed before recognition was built.
const std::vector<Visit>& season_visits();

/// A scan with where it was taken.
struct SeasonScan {
  PosedScan scan;
  Eigen::Isometry3d T_map_vehicle = Eigen::Isometry3d::Identity();
};

/// Scans of a visit.
struct SeasonDrive {
  Rig rig;  ///< an HDL-64E and a ring of five cameras of 240 by 180 pixels
  std::vector<SeasonScan> scans;
};

/// Renders a scan every `spacing` m along a route of a street map (nodes), in the world of a seed
/// that is built along `built_along`.
Result<SeasonDrive> render_visit(const std::string& map, uint64_t world_seed, const Visit& visit,
                                 std::vector<int64_t> route,
                                 const std::vector<int64_t>& built_along, double spacing);

}  // namespace infuse::study
