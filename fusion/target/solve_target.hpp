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
  double range_noise =
      0.02;  ///< m along the beam, one standard deviation (P 3.2.2); what the
             ///< returns' distances from their planes show is used where it is more
  double max_mahalanobis =
      5;  ///< a view whose board lies so many standard deviations off is rejected
  double inlier_tolerance = 0.01;  ///< m of offset plus rad of tilt; what lies no farther off stays
  double max_rotation_sigma = 0.005;  ///< rad; a direction known worse than that is not determined
  double max_translation_sigma = 0.02;  ///< m; the same
  uint64_t seed = 1;

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// What the solution says of one view.
struct ViewResidual {
  double rms = 0;          ///< m, distance of the returns from the board
  double offset = 0;       ///< m, mean of the same, along the board's normal
  double tilt = 0;         ///< rad, between the returns' plane and the board
  double mahalanobis = 0;  ///< how many standard deviations offset and tilts lie off, together
  bool used = true;        ///< false: an outlier, the solution does without it
};

/// What the views say of T_refcam_lidar.
struct TargetResult {
  Eigen::Isometry3d T_refcam_lidar = Eigen::Isometry3d::Identity();
  /// (rx, ry, rz, tx, ty, tz), rad and m, of a left perturbation of T_refcam_lidar.
  geometry::Matrix6 covariance = geometry::Matrix6::Identity();
  std::vector<ViewResidual> views;  ///< an entry a view
  int used = 0;                     ///< views that are no outliers
  double rms = 0;                   ///< m, over the returns of these, P(3.10)
  double range_noise = 0;           ///< m, as used
  std::string reason;               ///< why it cannot be used; empty when it can

  bool usable() const { return reason.empty(); }
};

/// Finds T_refcam_lidar from views of boards: P(3.10) minimised by Levenberg–Marquardt (Ceres),
/// every view weighted by what its corners and its returns are worth, from where most views agree,
/// or from `T_initial` where three views do not determine it. Views that lie too far off are left
/// out and the rest is solved again until nothing changes. Covariance after P(3.12) and appendix B,
/// with the boards' poses and the ranges as measurements.
///
/// Not usable, with the direction named: normals that all lie in one plane or are all parallel
/// (P 3.2.3), an axis known worse than the options ask for; most views outliers. Views must hold at
/// least three returns each.
TargetResult solve_target(std::span<const TargetView> views, const Eigen::Isometry3d& T_initial,
                          const SolveTargetOptions& options);

}  // namespace infuse::target
