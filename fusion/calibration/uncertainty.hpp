#pragma once

#include <string>
#include <vector>

#include "fusion/calibration/objective.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::calibration {

/// Uncertainty of a calibration. Covariances are ordered (rx, ry, rz, tx, ty, tz), rad and m, of
/// a left perturbation of T_refcam_lidar.
struct Uncertainty {
  geometry::Matrix6 covariance = geometry::Matrix6::Identity();  ///< from the spread of the scenes
  geometry::Matrix6 curvature = geometry::Matrix6::Zero();  ///< −∂²value/∂ξ², in the measure's unit
  /// Cramér–Rao bound P(3.20): the covariance if all returns were independent of each other, which
  /// returns of one scene are not.
  geometry::Matrix6 cramer_rao_bound = geometry::Matrix6::Identity();
  std::vector<double>
      scene_influence;  ///< standard deviations by which each scene alone would move the result
  std::vector<SceneGradient> scene_gradients;  ///< Objective::scene_gradients at the result
  std::vector<Eigen::Matrix<double, 10, 6>> scene_curvature;  ///< −∂(scene gradient)/∂ξ
  std::string reason;  ///< why it is unknown: a direction that nothing determines; or empty

  bool usable() const { return reason.empty(); }
};

/// Estimates the uncertainty at a maximum. With H the curvature of the objective (central
/// differences of its analytic gradient) and g_s the gradient of scene s's part less their mean
/// (they add up to zero at the maximum itself), the estimate's covariance is
///   H⁻¹ (S/(S−6) Σ_s g_s g_sᵀ) H⁻¹
/// (the sandwich of M-estimation with scenes as clusters; Huber 1967). Scenes must be independent
/// of each other; returns within a scene need not be, unlike for the Cramér–Rao bound P(3.20).
///
/// Not usable, with the direction named, if H is not positive along a direction, or so flat that
/// the standard deviation there exceeds 5° or 50 cm (far-field only, P 3.4.1.2).
Uncertainty estimate_uncertainty(Objective& objective, const Eigen::Isometry3d& T_refcam_lidar);

}  // namespace infuse::calibration
