#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>

namespace infuse::target {

/// A flat checkerboard. Its frame: origin at the first inner corner, x along a row of corners, y
/// along a column, z = 0 on the board, P(3.1).
struct Board {
  int columns = 7;           ///< inner corners in a row
  int rows = 5;              ///< inner corners in a column
  double square_size = 0.1;  ///< m, side of a square

  /// What is wrong with the board, or nothing.
  std::optional<std::string> invalid() const;

  size_t corner_count() const { return static_cast<size_t>(columns) * static_cast<size_t>(rows); }

  /// A corner in the board's frame, m; row by row.
  Eigen::Vector3d corner(size_t index) const;

  /// Middle of the board, m, board frame.
  Eigen::Vector3d middle() const;

  /// Half of the board's sides along x and y, outermost squares included, m.
  Eigen::Vector2d half_size() const;
};

}  // namespace infuse::target
