#pragma once

#include <Eigen/Core>
#include <vector>

#include "fusion/streetmap/segment.hpp"

namespace infuse::streetmap {

/// Points in order, m east and north of the map's origin.
using Polyline = std::vector<Eigen::Vector2d>;

/// A stretch of ground along a line: a street, a footway, a crossing.
struct PlanStrip {
  Segment segment;
  Polyline points;
  double half_width = 0;      ///< m
  double kerb_width = 0;      ///< m, width of the boundary line outside its edge; 0: none
  double sidewalk_width = 0;  ///< m, pavement outside the kerb that the map does not draw; 0: none
};

/// A piece of ground within rings (even-odd rule, so that rings within rings are holes).
struct PlanArea {
  Segment segment;
  std::vector<Polyline> rings;  ///< without the repeated first point
  double wall_width = 0;        ///< m, width of the boundary line on the rings; 0: none
};

/// A street map as lines and areas.
struct StreetPlan {
  double latitude = 0;   ///< rad, WGS 84, of the origin
  double longitude = 0;  ///< rad
  std::vector<PlanStrip> strips;
  std::vector<PlanArea> areas;
};

/// Area of a ring, positive where it turns counter-clockwise, m².
double signed_area(const Polyline& ring);

/// Whether two edges of a ring that are not neighbours cross or touch.
bool crosses_itself(const Polyline& ring);

}  // namespace infuse::streetmap
