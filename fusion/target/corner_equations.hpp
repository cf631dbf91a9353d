#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "fusion/geometry/camera_model.hpp"
#include "fusion/target/board.hpp"
#include "fusion/target/find_boards.hpp"
#include "fusion/target/intrinsics_vector.hpp"

namespace infuse::target {

/// What all views share: the intrinsics, then bow along x, twist and bow along y of the board (m).
using SharedVector = Eigen::Matrix<double, 12, 1>;

/// Reprojection errors of a board's corners in one image, and their derivatives.
struct CornerEquations {
  Eigen::VectorXd residual;                             ///< px; u, v of each corner
  Eigen::Matrix<double, Eigen::Dynamic, 12> by_shared;  ///< by the SharedVector
  /// By a left perturbation of T_camera_board.
  Eigen::Matrix<double, Eigen::Dynamic, 6> by_pose;
};

/// Projects the corners of a board with bow. Returns nullopt if one does not project.
/// `corners.size()` must be `board.corner_count()`.
std::optional<CornerEquations> linearize_corners(const geometry::CameraModel& camera,
                                                 const Board& board, const Eigen::Vector3d& bow,
                                                 const Eigen::Isometry3d& T_camera_board,
                                                 const Corners& corners);

}  // namespace infuse::target
