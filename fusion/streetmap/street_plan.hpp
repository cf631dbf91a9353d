#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "fusion/streetmap/segment.hpp"

namespace infuse::streetmap {

/// Points in order, m east and north of the map origin.
using Polyline = std::vector<Eigen::Vector2d>;

/// Area along a line: a street, a footway, a crossing; or, with the kind kWater, the water on the
/// right of a coastline.
struct PlanStrip {
  Segment segment;                  ///< what it is
  Polyline points;                  ///< the line
  double half_width = 0;            ///< m
  double kerb_width = 0;            ///< m, width of the boundary line outside the edge; 0: none
  double left_sidewalk_width = 0;   ///< m, width of the pavement outside the kerb that the map does
  double right_sidewalk_width = 0;  ///< not draw, on the left and right of the line; 0: none
  int layer = 0;  ///< level of a carriageway, -16 … 15: those of other layers make no junction with
                  ///< it, but where they share a point
  bool tunnel = false;  ///< a carriageway below ground, which is not drawn
};

/// Area within rings (even-odd rule, so rings within rings are holes).
struct PlanArea {
  Segment segment;              ///< what it is
  std::vector<Polyline> rings;  ///< without the repeated first point
  double wall_width = 0;        ///< m, width of the boundary line along the rings; 0: none
};

/// Street map as lines and areas.
struct StreetPlan {
  double latitude = 0;            ///< rad, WGS 84, of the origin
  double longitude = 0;           ///< rad
  std::vector<PlanStrip> strips;  ///< lines
  std::vector<PlanArea> areas;    ///< areas
  Eigen::AlignedBox2d limit;      ///< m, nothing is drawn outside; empty: no limit
};

/// Area of a ring, m²; positive if counter-clockwise.
double signed_area(const Polyline& ring);

/// True if two non-adjacent edges of a ring cross or touch.
bool crosses_itself(const Polyline& ring);

}  // namespace infuse::streetmap
