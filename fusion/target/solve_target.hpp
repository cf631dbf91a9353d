#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fusion/target/target_model.hpp"
#include "fusion/target/target_solution.hpp"
#include "fusion/target/target_view.hpp"

namespace infuse::target {

/// Settings of the target-based calibration.
struct SolveTargetOptions {
  SharedErrors errors;         ///< of all views
  double max_mahalanobis = 5;  ///< standard deviations; boards beyond are rejected: one in 10⁶ of a
                               ///< Gaussian
  double max_rejected = 0.25;         ///< maximum share of the boards; unusable beyond
  double max_rotation_sigma = 0.005;  ///< rad; maximum standard deviation of a determined direction
  double max_translation_sigma = 0.02;  ///< m; the same for translations
  uint64_t seed = 1;

  /// Returns what is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Residuals of one view at the solution.
struct ViewResidual {
  double rms = 0;          ///< m, distances of the returns from the shifted board, along the beam
  double offset = 0;       ///< m, shift of the board's middle along its normal, by the returns
  double tilt = 0;         ///< rad, tilt of the board by the returns
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
  double range_noise = 0;           ///< m along the beam, of one return
  Misfit misfit;                    ///< of the boards
  double beam_bias = 0;             ///< m, root mean square of the beams' range biases, beside that
                                    ///< of all
  double contrast_bias = 0;         ///< m, range of the brightest minus that of the darkest returns
  double leave_one_out = 0;         ///< `leave_one_out_ratio`; the covariance is widened by it if
                                    ///< it is above 1
  std::string reason;               ///< why it is unusable; empty if usable

  bool usable() const { return reason.empty(); }
};

/// Estimates T_refcam_lidar from views of boards: P(3.10), with the errors that views share as
/// parameters beside the pose (`TargetModel`), every view weighted by the covariance of its corners
/// and returns and by the boards' misfit, which is estimated. The initial pose is the consensus of
/// the views, or `T_initial` if no three views determine one. The start is robust: boards weigh
/// less the farther they are from the others (Student's t), and those beyond `max_mahalanobis` are
/// rejected. The covariance follows P(3.12) and appendix B, widened for the misfit's own
/// uncertainty, and where leaving out single views changes the pose more than it states.
///
/// Unusable, with the reason: all normals coplanar or parallel (P 3.2.3), an axis with a larger
/// standard deviation than the options allow; more boards rejected than they allow; a misfit of the
/// boards beyond the same limits, since it may be common to all of them. Every view needs at least
/// three returns.
TargetResult solve_target(std::span<const TargetView> views, const Eigen::Isometry3d& T_initial,
                          const SolveTargetOptions& options);

}  // namespace infuse::target
