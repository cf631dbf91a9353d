#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "fusion/geometry/camera_model.hpp"
#include "fusion/target/board.hpp"
#include "fusion/target/find_boards.hpp"

namespace infuse::target {

/// Pose of a board by OpenCV's plane-based solver, which needs no camera model: from the directions
/// of the corners on a plane across the middle one, so that a board at the rim of a fisheye's image
/// has a pose too. Returns nullopt if a corner has no direction in the model, if the board fills
/// more than 170°, or if a corner of it does not project.
std::optional<Eigen::Isometry3d> estimate_initial_board_pose(const geometry::CameraModel& camera,
                                                             const Board& board,
                                                             const Corners& corners);

}  // namespace infuse::target
