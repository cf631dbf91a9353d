#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fusion/calibration/coarse_to_fine.hpp"
#include "fusion/calibration/scene_support.hpp"
#include "fusion/calibration/uncertainty.hpp"

namespace infuse::calibration {

/// Settings of the target-less calibration.
struct CalibrateOptions {
  std::vector<TermOptions> terms;  ///< what is maximised; empty: the default measure, "joint"
  std::vector<Level> coarse{{.sigma = 8, .points = 40'000, .tolerance = 1e-2, .anchored = true},
                            {.sigma = 4, .points = 40'000, .tolerance = 1e-2, .anchored = true},
                            {.sigma = 2, .points = 40'000, .tolerance = 5e-3}};
  std::vector<Level> fine{{.sigma = 2}, {.sigma = 1.2, .passes = 2}};
  int starts = 4;                  ///< coarse searches: from the start itself and from around it
  double start_rotation = 0.02;    ///< rad each axis, half width of what is drawn around the start
  double start_translation = 0.1;  ///< m each axis: how well the start's translation is known (one
                                   ///< standard deviation); others are drawn within half of it
  double uncertainty_sigma = 3;    ///< px, blur of the images that tell uncertainty and support
  double min_support = 0.75;  ///< mean of SceneSupport::support below which nothing is believed
  uint64_t seed = 1;
  MaximizeOptions maximize;
  VisibilityOptions visibility;

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// What a calibration found, and whether one may believe it.
struct CalibrationResult {
  Eigen::Isometry3d T_head_lidar = Eigen::Isometry3d::Identity();
  Uncertainty uncertainty;
  double value = 0;                  ///< of the objective at the result, finest level
  double value_at_start = 0;         ///< the same points and level, at the start
  size_t points = 0;                 ///< that took part at the finest level
  int starts = 0;                    ///< coarse searches made
  int agreed = 0;                    ///< of these, such as ended near the result (0.5°, 8 cm)
  std::vector<SceneSupport> scenes;  ///< what each scene says by itself
  double support = 0;                ///< mean over the scenes that have points in view
  int evaluations = 0;               ///< of the objective, all searches together
  std::string reason;                ///< why it cannot be used; empty when it can

  bool usable() const { return reason.empty(); }
};

/// Finds T_head_lidar by maximising the dependence between what lidar and cameras see of the scenes
/// (P chapter III, I chapter 4). Coarse searches from several starts find the basin, with few
/// points and strong blur; the best end is refined with all points. Options must be valid, scenes
/// must hold the features that the terms name and at least 3 of them must have points in view.
CalibrationResult calibrate(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                            const Eigen::Isometry3d& T_head_lidar_start,
                            const CalibrateOptions& options);

}  // namespace infuse::calibration
