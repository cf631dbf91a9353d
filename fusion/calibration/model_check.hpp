#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/measurement/stamp.hpp"
#include "fusion/calibration/scene.hpp"
#include "fusion/calibration/uncertainty.hpp"

namespace infuse::calibration {

/// Standard deviations to which intrinsics and times are known; they go into the stated covariance.
/// The defaults are those of a careful calibration of a camera with a board, and of a triggered
/// camera.
struct KnownParameters {
  double focal_sigma = 0.002;          ///< of the logarithm of the focal lengths
  double principal_point_sigma = 0.5;  ///< px, across and down
  double radial_sigma = 0.005;         ///< of k1
  /// False: nobody states to what the intrinsics are known. Then what the scenes show of them alone
  /// bounds their errors (`unmeasured_errors`).
  bool intrinsics_stated = true;
  Duration time_sigma{1'000'000};  ///< between image and sweep

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Parameter that was assumed to be known, and its error as the scenes indicate it.
struct ParameterCheck {
  std::string parameter;  ///< "focal length of camera 0", …
  const char* unit = "";  ///< of `value`
  double value = 0;       ///< estimated error; 0 where the scenes do not determine it
  /// Standard deviation of `value`, from the spread of the scenes and the bias of the measure.
  double sigma = 0;
  double significance = 0;  ///< `value` in standard deviations, `sigma` and `known_sigma` together
  /// Change of the result (left perturbation of T_refcam_lidar, rad and m) per unit of error.
  geometry::Vector6 pose_sensitivity = geometry::Vector6::Zero();
  double known_sigma = 0;  ///< standard deviation to which it is known, in `unit`
  /// Standard deviation beyond `known_sigma` that the scenes do not exclude (`unseen_errors`,
  /// `unmeasured_errors`).
  double unseen_sigma = 0;
  /// Error of it, in `unit`, that `detect_gross_error` shows in at least half of the cases (50 to
  /// 66 %), see `detection_limits`; empty: not estimated.
  std::optional<double> detection_limit;
  double tolerance = 0;  ///< error that a good calibration leaves, in `unit`

  /// Worth reporting: 3.5 standard deviations, and more than a careful calibration leaves.
  bool significant = false;
  /// More than chance and small imperfections of real scenes cause: 7 standard deviations.
  bool serious = false;
  /// Found by estimating it (`estimate_intrinsics`): larger than any calibration of it leaves.
  bool gross = false;
};

/// Makes the check of one of a camera's four intrinsics (logarithm of the focal lengths,
/// principal point across and down, k1): `error` of the camera with this index of `cameras`.
ParameterCheck make_intrinsic_check(size_t intrinsic, double error, size_t camera, size_t cameras);

/// Checks intrinsics and clocks, which are assumed to be known while a pose is estimated. Where
/// they are wrong, the pose compensates for them as well as it can, and its covariance does not
/// show it; but the scenes' gradients by the wrong parameter do not vanish. At the maximum the
/// score of a further parameter e, less what the pose can explain,
///   s = Σ_s (∂_e f_s − I_eξ I_ξξ⁻¹ ∂_ξ f_s)
/// is zero but for chance (Rao's score test, efficient scores), and the scenes' spread gives the
/// size of chance. I is Fisher's information (`Objective::scene_information`); differences of the
/// gradients in place of it are so noisy that a principal point's effect on a sparse lidar's pose
/// came out with the wrong sign. s divided by its curvature is the estimated error of e, and the
/// pose follows e by −I_ξξ⁻¹ I_ξe.
///
/// Checks focal length, principal point and first radial distortion coefficient of every camera;
/// with scenes of known motion also the time between sweep and image. Returns nothing without a
/// usable uncertainty; with fewer than 10 effective scenes no value and no significance.
std::vector<ParameterCheck> check_model(const Eigen::Isometry3d& T_refcam_lidar, size_t cameras,
                                        std::span<const Scene> scenes,
                                        const Uncertainty& uncertainty,
                                        const KnownParameters& known = {});

/// Covariance of the result from what is not known of these parameters: Σ σ² w wᵀ with their
/// `known_sigma`, `unseen_sigma` and `pose_sensitivity`. Where the scenes contradict them by more
/// than chance, the mean square of their values, in standard deviations with the tolerance, exceeds
/// one, and so does what the covariance from the `scenes` misses: (mean square − 1) times it is
/// added (Birge's ratio; Birge 1932).
geometry::Matrix6 model_covariance(std::span<const ParameterCheck> parameters,
                                   const geometry::Matrix6& scenes);

}  // namespace infuse::calibration
