#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>

namespace infuse::target {

/// Planar checkerboard. Board frame: origin at the first inner corner, x along a row of corners, y
/// along a column, z = 0 on the board, P(3.1).
struct Board {
  int columns = 7;           ///< inner corners per row
  int rows = 5;              ///< inner corners per column
  double square_size = 0.1;  ///< m, side length of a square

  /// Returns what is wrong with the board, or nothing.
  std::optional<std::string> invalid() const;

  /// Sets columns and rows from "7x5"; returns false if the text is anything else.
  bool set_corners(const std::string& text);

  size_t corner_count() const { return static_cast<size_t>(columns) * static_cast<size_t>(rows); }

  /// Returns a corner in the board frame, m; indices run row by row.
  Eigen::Vector3d corner(size_t index) const;

  /// Centre of the board, m, board frame.
  Eigen::Vector3d middle() const;

  /// Height over the plane per metre of bow along x, twist, and bow along y, at a place relative to
  /// the middle and the half size, without the mean over the corners, which is part of the pose by
  /// them.
  Eigen::Vector3d bow_at(const Eigen::Vector2d& at) const;

  /// Half side lengths of the board along x and y, including the outermost squares, m.
  Eigen::Vector2d half_size() const;
};

}  // namespace infuse::target
