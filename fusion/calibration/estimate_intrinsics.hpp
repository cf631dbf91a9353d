#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "fusion/calibration/image_pyramid.hpp"
#include "fusion/calibration/model_check.hpp"
#include "fusion/calibration/uncertainty.hpp"
#include "fusion/calibration/visible_points.hpp"

namespace infuse::calibration {

/// Minimum number of scenes that determine intrinsics.
inline constexpr int kMinScenesOfIntrinsics = 8;

/// Estimate of one camera's intrinsics.
struct IntrinsicsEstimate {
  Eigen::Isometry3d T_refcam_lidar = Eigen::Isometry3d::Identity();  ///< estimated with them
  /// Estimated minus given: the logarithm of the focal lengths, the principal point (u, v, px), the
  /// first radial distortion coefficient. Without the prior that bounds the search.
  Eigen::Vector4d correction = Eigen::Vector4d::Zero();
  /// Covariance of `correction`, from the spread of the scenes as `estimate_uncertainty`.
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  /// The last level ended at a maximum, at most 10 % of the focal length, 7.5 % of it in the
  /// principal point and 0.15 in k1 from the given intrinsics.
  bool converged = true;
  int scenes = 0;           ///< number of the camera's scenes that were compared
  int improved_scenes = 0;  ///< number of these that fit better than with the given intrinsics
  /// Mean gain of a scene divided by its standard error (Student's t).
  double significance = 0;
};

/// Maximises the dependence over the pose and one camera's intrinsics together, coarse to fine, the
/// `search_terms` and at the finest level `terms`, from the pose estimated with the given
/// intrinsics. Compares the fit of every scene alone, on the points in view with the given
/// intrinsics. Detects gross errors, for which the slope at the result (`check_model`) is not
/// valid. `uncertainty` is that of the pose. Returns nothing if fewer than `kMinScenesOfIntrinsics`
/// of the camera's scenes have enough points in view, or if `stop` was requested.
std::optional<IntrinsicsEstimate> estimate_intrinsics(
    std::span<const Scene> scenes, std::span<const RigCamera> cameras, size_t camera,
    std::span<const TermOptions> search_terms, std::span<const TermOptions> terms,
    ImagePyramid& images, const VisibilityOptions& visibility,
    const Eigen::Isometry3d& T_refcam_lidar, const Uncertainty& uncertainty,
    const std::stop_token& stop);

/// Blurs of the images that `estimate_intrinsics` looks up.
std::vector<ImageBlur> intrinsics_blurs();

/// Tests the four intrinsics together: Tsq = eᵀ (C + K)⁻¹ e, e the estimated correction, C its
/// covariance, K what they are known to (`known`, and errors that imperfections of real scenes
/// imitate: 0.5 % of the focal length, 1.5 px, 0.005 in k1). Beyond the 99 % quantile of χ²(4), if
/// the scenes fit better, returns the one that is farthest off, as serious; or the intrinsics as a
/// whole, without a value, if the estimate did not converge within its bounds. Otherwise nothing.
/// `cameras` have the given intrinsics.
std::optional<ParameterCheck> detect_gross_error(const IntrinsicsEstimate& estimate,
                                                 std::span<const RigCamera> cameras, size_t camera,
                                                 const KnownParameters& known);

/// Errors of the given intrinsics, each alone, that `detect_gross_error` shows in at least half of
/// the cases (50 to 66 %); smaller ones go unnoticed more often: √(13.28 / [(C + K)⁻¹]ᵢᵢ), in the
/// units of `correction`.
Eigen::Vector4d detection_limits(const IntrinsicsEstimate& estimate, const KnownParameters& known);

/// Standard deviations of errors of the given intrinsics that `detect_gross_error` would not have
/// shown. With a probability of 0.5 % each of the four is not as well known as stated, but that of
/// a camera that was never calibrated: e ~ N(0, w²), w = 2 % of the focal length, 2 % of it in the
/// principal point, 0.1 in k1. Its estimate is x ~ N(e, s²), with s² of `estimate`, `known` and the
/// errors that imperfections imitate; nothing is shown while x² ≤ 13.28 s². Returns
/// √(0.5 % E[e²; not shown]), in the units of `correction`; `focal_length` in px.
Eigen::Vector4d unseen_errors(const IntrinsicsEstimate& estimate, double focal_length,
                              const KnownParameters& known);

/// Root mean squares of the errors of given intrinsics that nobody has measured: each a priori as
/// of a camera that was never calibrated, e ~ N(0, w²) with w of `unseen_errors`, and an estimate
/// x ~ N(e, s²) where there is one: E[e² | x] = (q x)² + q s², q = w² ÷ (w² + s²). In the units of
/// `correction`; `focal_length` in px.
Eigen::Vector4d unmeasured_errors(const std::optional<IntrinsicsEstimate>& estimate,
                                  double focal_length, const KnownParameters& known);

}  // namespace infuse::calibration
