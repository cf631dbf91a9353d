#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>

namespace infuse::recording {

/// Converts a 4 × 4 matrix to a rigid motion. If the rotation deviates from orthonormality by at
/// most 1e-3 (printed digits), the nearest rotation is used; if by at most 1e-12, it is kept
/// unchanged. Returns nothing if the matrix is not a rigid motion.
std::optional<Eigen::Isometry3d> to_rigid(const Eigen::Matrix4d& matrix);

/// The same of 16 numbers by row; nothing if there are not as many.
std::optional<Eigen::Isometry3d> to_rigid(std::span<const double> by_row);

}  // namespace infuse::recording
