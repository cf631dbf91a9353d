#pragma once

#include <Eigen/Geometry>
#include <optional>

namespace infuse::recording {

/// The rigid motion that a published 4 × 4 matrix means. Its rotation may be off by the digits it
/// was printed with (up to 1e-3): the nearest rotation is taken. A rotation that is exact to 1e-12
/// is kept bit by bit. Nothing where the matrix is no rigid motion.
std::optional<Eigen::Isometry3d> to_rigid(const Eigen::Matrix4d& matrix);

}  // namespace infuse::recording
