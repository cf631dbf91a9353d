#pragma once

#include <span>
#include <string>
#include <vector>

#include "fusion/target/board_returns.hpp"
#include "fusion/target/solve_target.hpp"

namespace infuse::target {

/// Board detected in an image, with the lidar returns around it.
struct BoardObservation {
  Eigen::Isometry3d T_refcam_board = Eigen::Isometry3d::Identity();
  geometry::Matrix6 board_covariance = geometry::Matrix6::Zero();  ///< as in TargetView
  std::vector<BoardReturn> nearby_returns;                         ///< from `crop_to_board`
};

/// Result of the target-based calibration, T_refcam_lidar.
struct TargetCalibration {
  TargetResult result;                ///< one entry per observation in its `views`
  std::vector<size_t> return_counts;  ///< returns on the board, per observation
  std::vector<std::string> reasons;   ///< why an observation gave no view; empty if it gave one
};

/// Calibrates from observations of one kind of board in three passes. The first pass searches for
/// returns as far around a board as `T_initial` may be wrong, the second within 8 cm of the first
/// solution, the last only within the outline of the board, so that stands and walls behind it
/// cannot tilt the plane.
TargetCalibration calibrate_target(std::span<const BoardObservation> observations,
                                   const Board& board, const Eigen::Isometry3d& T_initial,
                                   const BoardReturnsOptions& returns_options,
                                   const SolveTargetOptions& solve_options);

}  // namespace infuse::target
