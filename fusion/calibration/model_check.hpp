#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fusion/calibration/objective.hpp"
#include "fusion/calibration/uncertainty.hpp"

namespace infuse::calibration {

/// Something that was taken for known, and what the scenes say of it.
struct ModelMismatch {
  std::string parameter;    ///< "focal length of camera 0", …
  const char* unit = "";    ///< of `value`
  double value = 0;         ///< by which it seems to be off; 0 where the scenes cannot tell how far
  double sigma = 0;         ///< standard deviation of `value`
  double significance = 0;  ///< standard deviations from none, as the scenes disagree
  /// How the result would move (left perturbation of T_head_lidar, rad and m) were it off by one
  /// unit.
  geometry::Vector6 pose_sensitivity = geometry::Vector6::Zero();

  /// Worth telling: 3.5 standard deviations, and more than a careful calibration leaves.
  bool significant = false;
  /// Beyond what chance and the lesser imperfections of real scenes do: 7 standard deviations.
  bool serious = false;
  /// Found by freeing it (`estimate_intrinsics`): farther off than any calibration of it leaves.
  bool gross = false;
};

/// A doubt about one of a camera's four intrinsics (logarithm of the focal lengths, principal point
/// across and down, k1), off by so much, of one of so many cameras.
ModelMismatch make_intrinsic_mismatch(size_t intrinsic, double error, size_t camera,
                                      size_t cameras);

/// A camera's intrinsics and clock are taken for known when its pose is estimated; where they are
/// wrong, the pose makes up for them as well as it can, and its covariance tells nothing of that.
/// But then every scene goes on to pull on what is wrong. At the maximum the score of a further
/// parameter e, cleared of what the pose can do,
///   s = Σ_s (∂_e f_s − h_eᵀ H⁻¹ ∂_ξ f_s),  H = −∂²_ξ f,  h_e = −∂_ξ ∂_e f,
/// is zero but for chance (Rao's score test, efficient scores), and the scenes' own spread tells
/// how large chance is. s divided by its curvature is what e seems to be off by.
///
/// Asked of every camera: focal length, principal point, first radial distortion coefficient; of
/// scenes that know their motion also the time between sweep and picture. Needs at least 10 scenes
/// in view; with fewer there is no answer and nothing is doubted.
std::vector<ModelMismatch> check_model(Objective& objective, const Eigen::Isometry3d& T_head_lidar,
                                       std::span<const RigCamera> cameras,
                                       std::span<const Scene> scenes,
                                       const Uncertainty& uncertainty);

}  // namespace infuse::calibration
