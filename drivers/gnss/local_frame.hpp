#pragma once

#include <Eigen/Core>
#include <GeographicLib/LocalCartesian.hpp>

namespace infuse::gnss {

/// East-north-up frame at an origin on the WGS 84 ellipsoid. The functions below convert between
/// its units (degrees) and those of infuse: radians, metres above the ellipsoid. The frame is
/// Cartesian, not a projection: at distance d the ground is d²/12 740 km below its horizontal
/// plane.
using LocalFrame = GeographicLib::LocalCartesian;

/// Returns the frame at an origin (rad, rad, m).
LocalFrame make_local_frame(double latitude, double longitude, double altitude = 0);

/// Converts latitude, longitude, altitude (rad, rad, m) to metres east, north, up of the origin, in
/// steps of 1/4096 m: the same bits on all processors, but for a position in some 100 000.
Eigen::Vector3d to_local(const LocalFrame& frame, double latitude, double longitude,
                         double altitude = 0);

/// Converts metres east, north, up of the origin to latitude, longitude, altitude (rad, rad, m).
Eigen::Vector3d to_geodetic(const LocalFrame& frame, const Eigen::Vector3d& local);

}  // namespace infuse::gnss
