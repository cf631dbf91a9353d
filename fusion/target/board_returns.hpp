#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/sweep.hpp"
#include "fusion/target/target_view.hpp"

namespace infuse::target {

/// Settings of the search for a board's returns in a sweep.
struct BoardReturnsOptions {
  double margin = 0.25;  ///< m; maximum displacement of a board by errors of the initial extrinsics
  double max_tilt = 0.25;   ///< rad; maximum tilt by the same
  double thickness = 0.05;  ///< m; maximum distance of a return from the plane (2.5 σ of the range:
                            ///< 98.8 % of a Gaussian)
  int min_returns = 30;         ///< minimum number of returns on a board
  int ransac_iterations = 400;  ///< of three returns: with a third of them on the board, one in a
                                ///< million fails (Fischler and Bolles 1981)
  uint64_t seed = 1;

  /// Returns what is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Returns of a sweep within `margin` of the board placed by `T_lidar_board`.
std::vector<BoardReturn> crop_to_board(const Sweep& sweep, const Eigen::Isometry3d& T_lidar_board,
                                       const Board& board, double margin);

/// Finds the returns in `near` that lie on the board: within its outline grown by `grow` (m;
/// negative: shrunk) and on a plane found by RANSAC (Fischler and Bolles 1981). Errors: too few
/// returns, no plane with the orientation of the board.
Result<std::vector<BoardReturn>> find_board_returns(std::span<const BoardReturn> near,
                                                    const Eigen::Isometry3d& T_lidar_board,
                                                    const Board& board, double grow,
                                                    const BoardReturnsOptions& options);

}  // namespace infuse::target
