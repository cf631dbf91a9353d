#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fusion/calibration/coarse_to_fine.hpp"
#include "fusion/calibration/model_check.hpp"
#include "fusion/calibration/rotation_screen.hpp"
#include "fusion/calibration/scene_support.hpp"
#include "fusion/calibration/uncertainty.hpp"

namespace infuse::calibration {

/// Settings of the target-less calibration.
struct CalibrateOptions {
  std::vector<TermOptions> terms;  ///< what is maximised; empty: the default measure, "joint"
  /// What leads there, where `terms` take long or do not see far: all but the last of the fine
  /// levels, restarts, halvings and the scenes' support are by these. Empty: `terms` themselves, of
  /// the default measure its own.
  std::vector<TermOptions> search_terms;

  // Which basin: rotations are screened, the best climb; after each level the best ends go on.
  ScreenOptions screen;
  double screen_sigma = 8;        ///< px, blur at which rotations are screened
  size_t screen_points = 16'000;  ///< that take part in the screening
  size_t coarse_points = 60'000;  ///< that take part in the coarse climbs and their comparison
  std::vector<Level> coarse{{.sigma = 8, .tolerance = 2e-2, .prior_weight = 0.3, .survivors = 6},
                            {.sigma = 4, .tolerance = 2e-2, .prior_weight = 0.1, .survivors = 6},
                            {.sigma = 3, .tolerance = 1e-2, .prior_weight = 0.03, .survivors = 2},
                            {.sigma = 2, .tolerance = 1e-2}};
  double initial_translation_sigma = 0.1;  ///< m each axis, one standard deviation: how well the
                                           ///< start tells where the head stands in the lidar frame

  // Where in it.
  /// That take part in the fine climbs and in what is told of their end, beside all that are near
  /// depth edges. More of them take longer, and bring results no nearer to each other.
  size_t fine_points = 300'000;
  std::vector<Level> fine{{.sigma = 3, .points = 60'000, .tolerance = 5e-3},
                          {.sigma = 2, .points = 120'000, .tolerance = 5e-3},
                          {.sigma = 1}};

  // Whether to believe it.
  int restarts = 4;  ///< climbs from around the result, which ought to lead back to it
  double restart_rotation = 0.02;     ///< rad each axis, half width of what they are drawn from
  double restart_translation = 0.08;  ///< m each axis
  int splits = 0;             ///< random halvings of the scenes, whose estimates are compared
  double support_sigma = 3;   ///< px, blur of the images that tell the scenes' support
  double min_support = 0.88;  ///< mean of SceneSupport::support below which nothing is believed

  /// Whether intrinsics that are far off are looked for (`estimate_intrinsics`): where a camera
  /// whose intrinsics were once found right is only asked where it stands now, that time can be
  /// saved.
  bool check_intrinsics = true;

  uint64_t seed = 1;         ///< of the restarts
  MaximizeOptions maximize;  ///< its `stop` ends the whole soon: not usable then
  VisibilityOptions visibility;

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// What a calibration found, and whether one may believe it.
struct CalibrationResult {
  Eigen::Isometry3d T_refcam_lidar = Eigen::Isometry3d::Identity();
  Uncertainty uncertainty;
  std::vector<ModelMismatch>
      model_mismatches;              ///< what else seems to be off; empty where that is not known
  double value = 0;                  ///< of the objective at the result, finest level
  double initial_value = 0;          ///< the same points and level, at the start
  size_t points = 0;                 ///< that took part at the finest level
  int restarts = 0;                  ///< climbs from around the result
  int returned = 0;                  ///< of these, such as ended near it (0.3°, 4 cm)
  bool best_of_restarts = true;      ///< none of them found a better place
  std::vector<SceneSupport> scenes;  ///< what each scene says by itself
  double support = 0;                ///< mean over the scenes that have points in view
  int evaluations = 0;               ///< of the objective, all searches together
  /// Of `splits` halvings, a covariance (¼ mean of the squared difference of the two halves'
  /// estimates); absent where there were none.
  std::optional<geometry::Matrix6> split_half;
  std::string reason;  ///< why it cannot be used; empty when it can

  bool usable() const { return reason.empty(); }
};

/// Finds T_head_lidar by maximising the dependence between what lidar and cameras see of the scenes
/// (P chapter III, I chapter 4). Rotations around the start are screened with few points and strong
/// blur; the best of them climb; the best end is refined with all points. Options must be valid,
/// scenes must hold the features that the terms name and at least 3 of them must have points in
/// view.
CalibrationResult calibrate(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                            const Eigen::Isometry3d& T_refcam_lidar_initial,
                            const CalibrateOptions& options);

}  // namespace infuse::calibration
