#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fusion/target/target_view.hpp"

namespace infuse::target {

/// Settings of the target-based calibration.
struct SolveTargetOptions {
  double range_noise = 0.02;   ///< m along the beam, standard deviation (P 3.2.2); the value
                               ///< estimated from the returns' distances to their planes is used if
                               ///< it is larger
  double max_mahalanobis = 5;  ///< standard deviations; views beyond are rejected: one in 10⁶ of a
                               ///< Gaussian
  double inlier_tolerance = 0.01;     ///< m of offset plus rad of tilt; views within are never
                                      ///< rejected
  double max_rotation_sigma = 0.005;  ///< rad; maximum standard deviation of a determined direction
  double max_translation_sigma = 0.02;  ///< m; the same for translations
  uint64_t seed = 1;

  /// Returns what is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Residuals of one view at the solution.
struct ViewResidual {
  double rms = 0;          ///< m, distance of the returns from the board
  double offset = 0;       ///< m, mean of the same, along the normal of the board
  double tilt = 0;         ///< rad, between the plane of the returns and the board
  double mahalanobis = 0;  ///< Mahalanobis distance of offset and tilts together
  bool used = true;        ///< false: outlier, not part of the solution
};

/// Result of the target-based calibration, T_refcam_lidar.
struct TargetResult {
  Eigen::Isometry3d T_refcam_lidar = Eigen::Isometry3d::Identity();
  /// (rx, ry, rz, tx, ty, tz), rad and m, of a left perturbation of T_refcam_lidar.
  geometry::Matrix6 covariance = geometry::Matrix6::Identity();
  std::vector<ViewResidual> views;  ///< one entry per view
  int used = 0;                     ///< number of inlier views
  double rms = 0;                   ///< m, over the returns of the inlier views, P(3.10)
  double range_noise = 0;           ///< m, as used
  std::string reason;               ///< why it is unusable; empty if usable

  bool usable() const { return reason.empty(); }
};

/// Estimates T_refcam_lidar from views of boards: minimises P(3.10) by Levenberg–Marquardt (Ceres),
/// with every view weighted by the covariance of its corners and returns. The initial pose is the
/// consensus of the views, or `T_initial` if no three views determine one. Outlier views are
/// removed and the problem is solved again until nothing changes. The covariance follows P(3.12)
/// and appendix B, with the poses of the boards and the ranges as measurements.
///
/// Unusable, with the direction in the reason: all normals coplanar or parallel (P 3.2.3), an axis
/// with a larger standard deviation than the options allow; or most views are outliers. Every view
/// needs at least three returns.
TargetResult solve_target(std::span<const TargetView> views, const Eigen::Isometry3d& T_initial,
                          const SolveTargetOptions& options);

}  // namespace infuse::target
