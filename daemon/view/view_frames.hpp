#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "daemon/pipeline/view_tap.hpp"
#include "daemon/protocol/json.hpp"
#include "drivers/measurement/rig.hpp"
#include "fusion/streetmap/segment_map.hpp"

namespace infuse::daemon {

/// Encodes a sweep as a binary message of the view: the length of a JSON text (uint32, as all
/// numbers little-endian), the text padded with blanks to a multiple of eight bytes, then `points`
/// times x, y, z (int16, cm, lidar frame), reflectivity and ring (uint8). The text: kind "sweep",
/// device, stamp (ns, as text: it exceeds the integers of JavaScript), points, deskewed,
/// T_vehicle_lidar and, with odometry, T_odom_vehicle, 4 × 4 row by row; with a place on the street
/// map T_map_vehicle, covariance_map (xx, xy, yy, m²) and, when unsure, particles (x, y, x, … m).
std::string encode_sweep(const ViewSweep& sweep, const Rig& rig);

/// Encodes an image in the same way: kind "image", device, stamp, width, height, intrinsics (model,
/// fx, fy, cx, cy, distortion), T_vehicle_lidar, T_camera_lidar in use and as the rig has it,
/// points; after the points the JPEG file `jpeg`.
std::string encode_image(const ViewImage& image, const std::vector<uint8_t>& jpeg, const Rig& rig);

/// A message that is its text alone.
std::string encode_frame(const Json& header);

/// Part of the street map around a point (m, map frame), as a binary message: kind "map", stamp,
/// no points, cell (m), columns, rows, x and y (m, map frame, of its south-west corner), and of a
/// map that is georeferenced origin_deg (latitude, longitude of the map frame's origin); then a
/// `streetmap::SegmentKind` (uint8) for each cell, row by row from the south.
std::string encode_map(const streetmap::SegmentMap& map, const Eigen::Vector2d& middle,
                       Stamp stamp);

}  // namespace infuse::daemon
