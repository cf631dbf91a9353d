#pragma once

#include <cstdint>
#include <vector>

#include "fusion/streetmap/street_plan.hpp"
#include "tests/study/starts/drawn_network.hpp"

namespace infuse::study {

/// Points of the streets of a map, and which are joined.
struct StreetNetwork {
  std::vector<Eigen::Vector2d> points;  ///< m, map frame
  std::vector<std::vector<int>> joined;
};

/// Network of the carriageways of a plan that are wider than a driveway. Streets join where they
/// share a point; those that lead nowhere are left out.
StreetNetwork network_of(const streetmap::StreetPlan& plan);

/// Points where three or more streets meet.
std::vector<Eigen::Vector2d> crossings(const StreetNetwork& network);

/// A drive of `length` (m) along random streets of a network without turning back, on the right,
/// where the streets of the world are a metre beside those of the map. Fewer poses if no walk is
/// that long.
PlanarDrive draw_drive(const StreetNetwork& network, uint64_t seed, double length);

}  // namespace infuse::study
