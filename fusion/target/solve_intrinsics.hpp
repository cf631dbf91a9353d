#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <vector>

#include "fusion/target/corner_equations.hpp"

namespace infuse::target {

/// Intrinsics and the poses of the views that determine them.
struct IntrinsicsSolution {
  CameraIntrinsics camera;
  Eigen::Vector3d bow = Eigen::Vector3d::Zero();  ///< m; along x, twist, along y of the board
  /// One for each view; nothing where no pose of the board fits.
  std::vector<std::optional<Eigen::Isometry3d>> T_camera_board;
  bool converged = false;
};

/// Initial value of `solve_intrinsics`: principal point in the middle of the image, no distortion,
/// and that focal length of a geometric series for which poses of the boards fit best. `camera`
/// states model, width and height. Returns nullopt if no focal length has a pose for half the
/// views.
std::optional<IntrinsicsSolution> guess_intrinsics(const CameraIntrinsics& camera,
                                                   const Board& board,
                                                   std::span<const Corners> views);

/// Weights of `solve_intrinsics`.
struct IntrinsicsWeights {
  double corner_noise = 0.2;  ///< px; standard deviation per axis, relative to `flatness`
  double flatness = 0.002;    ///< m; as `SharedErrors::flatness`
  /// Views whose corners are farther off than this weigh less (Cauchy); 0: all weigh alike.
  double robust_rms = 0;  ///< px
};

/// Least squares of the reprojection errors of the views that have a pose (`used`: those of them to
/// use), over intrinsics, board's bow and poses; from `solution`, which it improves.
void solve_intrinsics(const Board& board, std::span<const Corners> views,
                      const std::vector<bool>& used, const IntrinsicsWeights& weights,
                      IntrinsicsSolution& solution);

}  // namespace infuse::target
