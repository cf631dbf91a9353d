#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/sweep.hpp"
#include "fusion/target/board.hpp"

namespace infuse::target {

/// How a board's returns are found in a sweep.
struct BoardReturnsOptions {
  double margin = 0.25;     ///< m; how far the given extrinsics may put a board off its place
  double max_tilt = 0.25;   ///< rad; how far they may tilt it
  double thickness = 0.05;  ///< m; a return this near to the plane is on it (2.5 σ of the range)
  int min_returns = 30;     ///< returns; with fewer the board is not seen
  int ransac_iterations = 400;  ///< of three returns each
  uint64_t seed = 1;

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// The returns of a sweep (m, lidar frame) within `margin` of where `T_lidar_board` puts a board.
std::vector<Eigen::Vector3d> crop_to_board(const Sweep& sweep,
                                           const Eigen::Isometry3d& T_lidar_board,
                                           const Board& board, double margin);

/// Those of `near` that lie on the board: in its outline, grown by `grow` (m; negative: shrunk),
/// and on a plane, by RANSAC (Fischler and Bolles 1981). Errors: too few returns there, no plane
/// among them that faces as the board does.
Result<std::vector<Eigen::Vector3d>> find_board_returns(std::span<const Eigen::Vector3d> near,
                                                        const Eigen::Isometry3d& T_lidar_board,
                                                        const Board& board, double grow,
                                                        const BoardReturnsOptions& options);

}  // namespace infuse::target
