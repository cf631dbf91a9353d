#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>

#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::registration {

/// Pose of one cloud in the frame of another, or the reason why it is not known.
struct RegistrationResult {
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();  ///< the pose
  /// Inverse of `covariance`, without information in the free directions.
  geometry::Matrix6 information = geometry::Matrix6::Zero();
  /// Left perturbation in the target frame, (rx, ry, rz, tx, ty, tz), rad and m; in the free
  /// directions it is `kFreeVariance`.
  geometry::Matrix6 covariance = geometry::Matrix6::Zero();
  /// Number of directions that the geometry leaves free (along a tunnel, across a field), and those
  /// directions: unit twists about the middle of the inliers, in units of the inliers' displacement
  /// (root mean square, m). The pose keeps the guess there.
  int free_directions = 0;
  std::array<geometry::Vector6, 6> free{};  ///< the first `free_directions`
  double rms = 0;                           ///< m, of the inliers' distances from the planes
  size_t inliers = 0;      ///< points of the source with a counterpart in the target
  size_t points = 0;       ///< points of the source
  int iterations = 0;      ///< Gauss–Newton steps
  bool converged = false;  ///< the last step was below the tolerances
  const char* reason = "no clouds were given";  ///< static text; empty if the pose is usable

  /// Variance of a free direction, rad² and m².
  static constexpr double kFreeVariance = 1e4;

  /// True if the pose may be used, apart from its free directions.
  bool usable() const { return *reason == '\0'; }

  /// Names of the free directions: "translation along x, rotation about z"; empty if there is none.
  std::string free_directions_text() const;
};

}  // namespace infuse::registration
