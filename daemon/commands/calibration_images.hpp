#pragma once

#include <span>
#include <string>

#include "daemon/commands/calibration_scenes.hpp"

namespace infuse::daemon {

/// The lidar's returns over the picture, by distance from red (3 m) to blue (60 m); hidden returns
/// are left out.
CameraFrame draw_overlay(const ScenePair& pair, const CameraIntrinsics& intrinsics,
                         const Eigen::Isometry3d& T_camera_lidar);

/// A table of numbers as a picture, a pixel a number, from the least (dark) to the greatest
/// (bright); row 0 is drawn at the bottom.
CameraFrame draw_map(std::span<const double> values, int columns);

/// A PNG file as a data: URL for an <img>.
std::string data_url(const CameraFrame& frame);

}  // namespace infuse::daemon
