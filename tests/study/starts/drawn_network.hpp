#pragma once

#include <cstdint>
#include <vector>

#include "fusion/streetmap/planar_pose.hpp"
#include "fusion/streetmap/street_plan.hpp"

namespace infuse::study {

/// Poses of the vehicle at equal times, map frame.
struct PlanarDrive {
  std::vector<streetmap::PlanarPose> poses;
  double period = 0.1;  ///< s between two poses
};

/// Drives along a line at 8 m/s, slower in bends; headings are those of the line.
PlanarDrive drive_along(const streetmap::Polyline& line);

/// The same on the right of the middle of streets, round their corners.
PlanarDrive drive_on_right(const streetmap::Polyline& middle);

/// A town drawn at random, and a drive through it that keeps to the right and does not turn back.
struct DrawnTown {
  streetmap::StreetPlan plan;
  PlanarDrive drive;
};

/// Draws a town of `edge` (m) squared: crossings on a lattice that is bent and thinned, streets
/// with bends, widths and an error of the map of a metre or two; the drive is `length` (m) long.
DrawnTown draw_town(uint64_t seed, double edge, double length);

}  // namespace infuse::study
