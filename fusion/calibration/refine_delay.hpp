#pragma once

#include <span>
#include <vector>

#include "fusion/calibration/calibrate.hpp"

namespace infuse::calibration {

/// Settings of the estimate of a delay.
struct DelayOptions {
  double max_delay = 0.1;    ///< s, largest error of the stamps that is searched for
  double step = 0.02;        ///< s, between the delays that are tried first
  double max_sigma = 0.005;  ///< s, of a usable delay

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// A calibration of a camera together with the delay of its stamps.
struct DelayCalibration {
  /// With the refined delay, whose uncertainty is part of `model_covariance`. Where it is not
  /// refined, not usable: the reason says why.
  CalibrationResult result;
  bool refined = false;
  double later = 0;  ///< s, the exposures' true times less the assumed ones
  double sigma = 0;  ///< s, standard deviation of `later`
};

/// Returns the scenes as they would be if each exposure were `later` (s): the lidar has then moved
/// by exp(ξ later), so that a return p lies at exp(−ξ later) p. ξ, the scene's twist, is taken as
/// constant. Scenes without one stay.
std::vector<Scene> scenes_exposed_later(std::span<const Scene> scenes, double later);

/// Calibrates with delays in steps, begins at the one with the highest dependence, and corrects it
/// by the time offset that the scenes indicate (`check_model`) until that is chance.
///
/// The delay is not refined where the motion of a scene is not known, with fewer than 10 effective
/// scenes, or where its standard deviation exceeds `max_sigma`: at constant speed on a straight
/// road it cannot be told from a shift of the camera along the road.
DelayCalibration calibrate_with_delay(std::span<const Scene> scenes,
                                      std::span<const RigCamera> cameras,
                                      const Eigen::Isometry3d& T_refcam_lidar_initial,
                                      const CalibrateOptions& options,
                                      const DelayOptions& delays = {});

}  // namespace infuse::calibration
