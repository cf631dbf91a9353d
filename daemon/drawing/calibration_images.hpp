#pragma once

#include <span>
#include <string>

#include "daemon/playback/calibration_scenes.hpp"

namespace infuse::daemon {

/// Indices of up to `count` pairs that still have an image and a sweep, spread evenly over these.
std::vector<size_t> choose_drawn(const ScenePairs& pairs, size_t count);

/// Draws the lidar's returns over the image, coloured by distance from red (3 m) to blue (60 m).
/// Occluded returns are left out.
CameraFrame draw_overlay(const ScenePair& pair, const CameraIntrinsics& intrinsics,
                         const Eigen::Isometry3d& T_camera_lidar);

/// Joins images of one format: rows of `columns` images, each row as high as its highest, black
/// where nothing is.
CameraFrame join_images(std::span<const CameraFrame> images, int columns);

/// Draws a table of numbers as a grey image, one pixel per number, from the minimum (dark) to the
/// maximum (bright); row 0 is at the bottom.
CameraFrame draw_map(std::span<const double> values, int columns);

/// Returns the frame as a PNG data: URL for an <img> element; empty if it cannot be encoded.
std::string data_url(const CameraFrame& frame);

}  // namespace infuse::daemon
