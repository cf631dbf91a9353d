#pragma once

#include <optional>

#include "fusion/geometry/camera_model.hpp"
#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/target/board.hpp"
#include "fusion/target/find_boards.hpp"

namespace infuse::target {

/// Where a board stands before a camera.
struct BoardPose {
  Eigen::Isometry3d T_camera_board = Eigen::Isometry3d::Identity();
  /// Of a left perturbation of T_camera_board, from `corner_noise`.
  geometry::Matrix6 covariance = geometry::Matrix6::Identity();
  double rms = 0;  ///< px, distance of corners from where the pose puts them
};

/// The pose that puts a board's corners where the picture shows them, P(3.5) with the intrinsics
/// known: a start from the homography, then Levenberg–Marquardt in pixels with the camera's own
/// model. Its covariance supposes that every corner is off by `corner_noise` pixels (one standard
/// deviation an axis) or by what the residuals show, whichever is more. Nothing where corners lie
/// outside what the model sees, or no pose fits them within 2 pixels.
std::optional<BoardPose> estimate_board_pose(const geometry::CameraModel& camera,
                                             const Board& board, const Corners& corners,
                                             double corner_noise);

}  // namespace infuse::target
