#pragma once

#include <optional>

#include "fusion/geometry/camera_model.hpp"
#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/target/board.hpp"
#include "fusion/target/find_boards.hpp"

namespace infuse::target {

/// Pose of a board in the camera frame.
struct BoardPose {
  Eigen::Isometry3d T_camera_board = Eigen::Isometry3d::Identity();
  /// Left perturbation of T_camera_board, from `corner_noise`.
  geometry::Matrix6 covariance = geometry::Matrix6::Identity();
  double rms = 0;  ///< px, reprojection error of the corners
};

/// Estimates the pose of a board from its corners in an image, P(3.5) with known intrinsics:
/// initial pose from the homography, then Levenberg–Marquardt on the reprojection error with the
/// camera's own model. The covariance assumes a corner noise of `corner_noise` pixels (one standard
/// deviation per axis) or that of the residuals, whichever is larger. Returns nullopt if corners
/// lie outside the model's range or no pose fits within 2 pixels.
std::optional<BoardPose> estimate_board_pose(const geometry::CameraModel& camera,
                                             const Board& board, const Corners& corners,
                                             double corner_noise);

}  // namespace infuse::target
