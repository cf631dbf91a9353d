#pragma once

#include <string>
#include <vector>

#include "fusion/calibration/objective.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::calibration {

/// Uncertainty of a calibration. Covariances are ordered (rx, ry, rz, tx, ty, tz), rad and m, of
/// a left perturbation of T_refcam_lidar.
struct Uncertainty {
  /// Of estimates with these cameras' models from other scenes of another drive: from the spread of
  /// the scenes, and `bias_covariance`; positive definite where `usable()`.
  geometry::Matrix6 covariance = geometry::Matrix6::Identity();
  /// The part that all scenes of a drive share: the measure's own bias. What scenes show of places
  /// of one kind (parked cars at one side, upper edges without lower ones) displaces the maximum of
  /// each drive by another amount, which their scatter does not show: by `kBiasSigma` in each band
  /// of depths, across and down, so Σ σ² (I⁻¹ b) (I⁻¹ b)ᵀ (`BiasInformation`).
  geometry::Matrix6 bias_covariance = geometry::Matrix6::Zero();
  double effective_scenes = 0;  ///< number of independent scenes that tell as much (with points)
  double design_effect = 1;     ///< `design_effect` of these scenes
  geometry::Matrix6 curvature = geometry::Matrix6::Zero();  ///< −∂²value/∂ξ², in the measure's unit
  /// Cramér–Rao bound P(3.20): the covariance if all returns were independent of each other, which
  /// returns of one scene are not.
  geometry::Matrix6 cramer_rao_bound = geometry::Matrix6::Identity();
  std::vector<double>
      scene_influence;  ///< standard deviations by which each scene alone would move the result
  std::vector<SceneGradient> scene_gradients;       ///< Objective::scene_gradients at the result
  std::vector<SceneInformation> scene_information;  ///< `PointInformation` at the result
  BiasInformation bias_information;                 ///< the same
  std::string reason;  ///< why it is unknown: a direction that nothing determines; or empty

  bool usable() const { return reason.empty(); }
};

/// Minimum of `Uncertainty::effective_scenes` of a usable result.
inline constexpr double kMinEffectiveScenes = 3;

/// Standard deviation of the displacement of pixels in a band of depths by which the maximum of the
/// dependence lies beside the truth, px. A ring meets an object below its upper edge, and a return
/// lies up to one step of azimuth inside an object's side. Half a pixel on drawn rigs and on real
/// drives (decision 18).
inline constexpr double kBiasSigma = 0.5;

/// First step of numeric second derivatives (decision 21), rad; for translations times the median
/// range of the points.
inline constexpr double kCurvatureStep = 1e-3;

/// Number of scenes that count as much as the curvature's shape, in the covariance (decision 21).
inline constexpr double kShrinkageScenes = 20;

/// Steps, as columns, along the axes of the `information` about the pose (any scale): each changes
/// the samples about as much as one radian, or the translation that moves points at `range` as far,
/// but is at most four times as long.
geometry::Matrix6 curvature_steps(const geometry::Matrix6& information, double range);

/// Curvature of the objective by the pose: minus the derivatives of its gradient, by differences
/// along the columns of `steps`. Rotation and translation together leave directions of little
/// information: along the axes of the pose itself, the noise of the large entries would hide the
/// small curvature there.
geometry::Matrix6 pose_curvature(Objective& objective, const Eigen::Isometry3d& T_refcam_lidar,
                                 const geometry::Matrix6& steps);

/// Estimates the uncertainty at a maximum. With H the curvature of the objective (central
/// differences of its analytic gradient) and g_s the gradient of scene s's part less their mean
/// (they add up to zero at the maximum itself), the estimate's covariance is
///   c H⁻¹ J H⁻¹,  J = (1 − λ) Ĵ + λ k H,  Ĵ = d S/(S−d) Σ_s g_s g_sᵀ
/// (the sandwich of M-estimation with scenes as clusters; Huber 1967). Scenes need not be
/// independent of each other: S of them count as E (`effective_scenes` of `similarity`), and d is
/// their `design_effect`; for independent ones E = S and d = 1. Ĵ has 21 entries from few
/// gradients; it is shrunk towards the curvature, which has the shape of Fisher's information and
/// takes its scale k from Ĵ (quasi-likelihood; Wedderburn 1974), with λ = 20 / (20 + E − 1). c
/// widens the covariance as few scenes require: it is the ratio of the 95 % quantiles of 6 F(6, 2(E
/// − 1)) and χ²(6), two degrees of freedom for each scene, as J has more from the shrinkage than
/// Hotelling's T² allows. To this the bias of the measure is added (`bias_covariance`).
///
/// `similarity` has one row a scene (`scene_similarity`); empty: all are independent. Not usable
/// with fewer than 3 effective scenes, or, with the direction named, if H is not positive along a
/// direction, or so flat that the standard deviation there exceeds 5° or 50 cm (far-field only, P
/// 3.4.1.2).
Uncertainty estimate_uncertainty(Objective& objective, const Eigen::Isometry3d& T_refcam_lidar,
                                 const Eigen::MatrixXd& similarity = {});

/// Returns which standard deviation exceeds its limit (rad, m), in the worst direction of rotation
/// or translation, for a message; an empty text if none does.
std::string describe_imprecision(const geometry::Matrix6& covariance, double max_rotation_sigma,
                                 double max_translation_sigma);

/// Returns the factor from the scatter of `scenes` gradients about their mean to the variance of
/// their sum, without bias: d S / (S − d) with their `design_effect` d.
double scatter_factor(double design_effect, size_t scenes);

}  // namespace infuse::calibration
