#pragma once

#include <span>
#include <string>
#include <vector>

#include "fusion/target/board_returns.hpp"
#include "fusion/target/solve_target.hpp"

namespace infuse::target {

/// A board that a camera saw, and what the lidar saw around it.
struct BoardObservation {
  Eigen::Isometry3d T_refcam_board = Eigen::Isometry3d::Identity();
  geometry::Matrix6 board_covariance = geometry::Matrix6::Zero();  ///< as TargetView's
  std::vector<Eigen::Vector3d> nearby_returns;  ///< `crop_to_board`, m, lidar frame
};

/// What the sightings say of T_refcam_lidar.
struct TargetCalibration {
  TargetResult result;                ///< an entry a sighting in its `views`
  std::vector<size_t> return_counts;  ///< on each sighting's board
  std::vector<std::string> reasons;   ///< why a sighting gave no view; empty where it did
};

/// Calibrates from sightings of one kind of board, in three passes: at first a board's returns are
/// looked for as far around as `T_initial` may be wrong, then within 8 cm of where the first
/// solution puts it, at last within its outline alone, so that stands and walls behind cannot tilt
/// it.
TargetCalibration calibrate_target(std::span<const BoardObservation> observations,
                                   const Board& board, const Eigen::Isometry3d& T_initial,
                                   const BoardReturnsOptions& returns_options,
                                   const SolveTargetOptions& solve_options);

}  // namespace infuse::target
