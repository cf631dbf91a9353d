#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/measurement/angles.hpp"
#include "fusion/calibration/coarse_to_fine.hpp"
#include "fusion/calibration/estimate_intrinsics.hpp"
#include "fusion/calibration/model_check.hpp"
#include "fusion/calibration/rotation_screen.hpp"
#include "fusion/calibration/scene_support.hpp"
#include "fusion/calibration/uncertainty.hpp"

namespace infuse::calibration {

/// Settings of the target-less extrinsic calibration.
struct CalibrateOptions {
  std::vector<TermOptions> terms;  ///< sum that is maximised; empty: the default measure, "joint"
  /// Sum that is maximised before that, where `terms` are slow or have a narrow convergence basin:
  /// used by all levels but the last, by restarts, split halves and the scenes' support. Empty:
  /// `terms` themselves; for the default measure its own.
  std::vector<TermOptions> search_terms;

  // Choice of the basin: rotations are screened, the best of them start an ascent, and the best
  // different maxima of each level go on to the next.
  ScreenOptions screen;           ///< of the rotations
  double screen_sigma = 8;        ///< px, blur for the screening, derived from `coarse`: its first
  size_t screen_points = 16'000;  ///< maximum number of points of the screening
  size_t coarse_points = 60'000;  ///< maximum number of points of the coarse levels
  /// Levels of the choice, the most blurred first.
  std::vector<Level> coarse{{.sigma = 8, .tolerance = 2e-2, .prior_weight = 0.3, .survivors = 6},
                            {.sigma = 4, .tolerance = 2e-2, .prior_weight = 0.1, .survivors = 6},
                            {.sigma = 3, .tolerance = 1e-2, .prior_weight = 0.03, .survivors = 2},
                            {.sigma = 2, .tolerance = 1e-2}};
  double initial_translation_sigma = 0.1;  ///< m each axis, standard deviation of the reference
                                           ///< camera's initial position in the lidar frame

  // Fine levels.
  /// Maximum number of points of the fine levels and the uncertainty, beside all that are near
  /// depth edges. More points take longer and do not reduce the spread of the results (decision 7).
  size_t fine_points = 300'000;
  /// The levels.
  std::vector<Level> fine{{.sigma = 3, .points = 60'000, .tolerance = 5e-3},
                          {.sigma = 2, .points = 120'000, .tolerance = 5e-3},
                          {.sigma = 1}};

  // Checks of the result.
  /// Number of ascents per batch from poses around the result, with 15 effective scenes and more;
  /// as many again where not all converge (decision 5).
  int restarts = 4;
  /// The same with fewer effective scenes, which have more maxima; at least `restarts` (decision
  /// 5).
  int restarts_of_few = 8;
  double restart_rotation = 0.04;     ///< rad each axis, half width (decision 5)
  double restart_translation = 0.12;  ///< m each axis, half width (decision 5)
  /// Number of ascents at the finest blur from poses around the result. At that blur the measure
  /// may have several maxima a few centimetres apart, which the blur of `restarts` hides: they all
  /// end at one, which may be the lower one (decision 4).
  int fine_restarts = 4;
  double fine_restart_rotation = 0.35 * kDegree;  ///< rad each axis, half width of these
  double fine_restart_translation = 0.1;          ///< m each axis, half width (decision 4)
  int splits = 0;  ///< number of random halvings of the scenes whose estimates are compared
  double support_sigma = 3;   ///< px, blur of the images for the scenes' support, see `ImageBlur`
  double min_support = 0.88;  ///< minimum mean of SceneSupport::support of a usable result
  double max_rotation_sigma = 0.2 * kDegree;  ///< rad, of a usable result, about any axis
  double max_translation_sigma = 0.05;        ///< m, of a right result by definition (accuracy.md)
  KnownParameters known;  ///< to what intrinsics and times are known: part of the covariance

  /// True: gross errors of the intrinsics are searched for (`estimate_intrinsics`). Not needed for
  /// a camera whose intrinsics are verified and whose pose alone may have changed.
  bool check_intrinsics = true;

  uint64_t seed = 1;             ///< of the restarts and halvings
  MaximizeOptions maximize;      ///< its `stop` ends the calibration early, without a usable result
  VisibilityOptions visibility;  ///< which points are compared

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Fine level for comparing many calibrations: few points, and the blur of the middle fine level,
/// for which scenes are already prepared.
Level quick_level(const CalibrateOptions& options);

/// Every blur of the images that a calibration looks up.
std::vector<ImageBlur> image_blurs(const CalibrateOptions& options);

/// Result of a calibration.
struct CalibrationResult {
  /// The estimate; without `has_pose` the initial pose.
  Eigen::Isometry3d T_refcam_lidar = Eigen::Isometry3d::Identity();
  bool has_pose = false;    ///< an ascent ended at it; false where nothing could be compared
  Uncertainty uncertainty;  ///< from the scenes alone
  geometry::Matrix6 model_covariance = geometry::Matrix6::Zero();  ///< from `known`
  /// Checks of intrinsics and clock, one per parameter; empty without a usable uncertainty.
  std::vector<ParameterCheck> parameter_checks;
  /// Joint estimate of each camera's intrinsics and the pose; empty without `check_intrinsics`.
  std::vector<std::optional<IntrinsicsEstimate>> intrinsics;
  double value = 0;                  ///< objective at the result, finest level
  double initial_value = 0;          ///< objective at the initial pose, same points and level
  size_t points = 0;                 ///< number of points at the finest level
  int restarts = 0;                  ///< number of ascents of the last round around the result
  int converged_restarts = 0;        ///< number of restarts that converged to it (0.3°, 4 cm)
  bool best_of_restarts = true;      ///< no restart found a larger value
  std::vector<SceneSupport> scenes;  ///< support by each scene alone
  double support = 0;                ///< mean over the scenes with points in view
  int evaluations = 0;               ///< number of evaluations of the objective
  /// Covariance from `splits` halvings (¼ mean of the squared difference of the two halves'
  /// estimates); absent without halvings.
  std::optional<geometry::Matrix6> split_half;
  std::string reason;  ///< why the result cannot be used; empty if it can

  bool usable() const { return reason.empty(); }  ///< it may be used

  /// Stated covariance of T_refcam_lidar.
  geometry::Matrix6 covariance() const { return uncertainty.covariance + model_covariance; }
};

/// Estimates T_refcam_lidar by maximising the dependence between features of lidar and cameras (P
/// chapter III, I chapter 4). Rotations around the initial pose are screened with few points and
/// strong blur, the best of them start an ascent, and the best result is refined with all points.
/// Options must be valid, and scenes must hold the features that the terms name. Without points in
/// view of at least 3 effective scenes (`Uncertainty`) the result is not usable.
CalibrationResult calibrate(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                            const Eigen::Isometry3d& T_refcam_lidar_initial,
                            const CalibrateOptions& options);

}  // namespace infuse::calibration
