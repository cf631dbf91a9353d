#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fusion/target/corner_equations.hpp"
#include "fusion/target/image_coverage.hpp"
#include "fusion/target/solve_target.hpp"
#include "fusion/target/target_model.hpp"

namespace infuse::target {

/// Settings of the calibration of a camera's intrinsics.
struct CalibrateIntrinsicsOptions {
  /// Minimum number of views; derived from the covariance's ratio of scores, which 8 views know to
  /// √(2 / (8 · 9)) = 17 %.
  size_t min_views = 8;
  double max_rejected = SolveTargetOptions{}.max_rejected;  ///< maximum share of the views
  /// px; a model that is farther off is not the camera's: the detector finds corners to 0.1 px
  /// (Duda and Frese 2018).
  double max_rms = 1;
  /// Of the focal length; derived from the 5 cm that `infuse calibrate` accepts: an error of 2 %
  /// shifts a camera by 13 cm.
  double max_focal_sigma = 0.005;
  double max_centre_sigma = 0.0035;  ///< rad; derived from the 0.2° that `infuse calibrate` accepts
  double flatness = SharedErrors{}.flatness;  ///< m; bow and twist of the board

  /// Returns what is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// One view of a board at the solution.
struct IntrinsicsView {
  Eigen::VectorXd residual;  ///< px; u, v of each corner; empty if no pose of the board fits
  double rms = 0;            ///< px, of the corners
  bool used = false;         ///< false: outlier, or no pose of the board fits
};

/// Result of the calibration of a camera's intrinsics.
struct IntrinsicsResult {
  CameraIntrinsics camera;     ///< the estimate
  Eigen::MatrixXd covariance;  ///< in the order of `intrinsics_names`; empty: not determined
  double corner_noise = 0;     ///< px; standard deviation per axis, by the residuals
  double view_ratio = 0;       ///< see `IntrinsicsCovariance`
  double rms = 0;              ///< px, of the corners of all views that are used
  double bow = 0;              ///< m; the largest of the board's bows and its twist
  double tilt_spread = 0;      ///< rad; the largest angle between two boards
  ImageCoverage coverage;
  std::vector<IntrinsicsView> views;  ///< one for each view
  size_t used = 0;                    ///< number of views
  std::string reason;                 ///< why it is unusable; empty if usable

  bool usable() const { return reason.empty(); }
  /// Standard deviation of a number; infinite if it is not determined.
  double sigma(int number) const;
};

/// Estimates a camera's intrinsics from views of a flat board: pinhole (Zhang 2000; Brown–Conrady
/// distortion) or fisheye (Kannala and Brandt 2006). `camera` states model, width and height;
/// all views have `board.corner_count()` corners. Views whose corners do not fit as the others' do
/// are named and left out. Focal length and principal point do not depend on the squares' size.
IntrinsicsResult calibrate_intrinsics(const CameraIntrinsics& camera, const Board& board,
                                      std::span<const Corners> views,
                                      const CalibrateIntrinsicsOptions& options);

}  // namespace infuse::target
