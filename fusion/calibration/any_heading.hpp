#pragma once

#include <span>

#include "fusion/calibration/calibrate.hpp"

namespace infuse::calibration {

/// Settings of a calibration without a guess of the camera's heading.
struct HeadingOptions {
  int headings = 12;  ///< evenly about the vertical axis of the lidar
  /// Rotations that are screened about each of them; what the camera may be tilted by.
  double half_width = 20 * kDegree;
  size_t verified = 3;  ///< headings with the largest dependence that are calibrated in full, …
  double min_share = 0.4;       ///< … the others of them only with this share of the largest
  double position_sigma = 0.3;  ///< m each axis, of the camera's initial position, at least

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Calibrates a camera that looks anywhere around the lidar, about upright (its tilt and its roll
/// within `half_width` of the initial ones): calibrates from every heading with few points, then in
/// full from those where lidar and images depend on each other most. Two that are usable and differ
/// make the result unusable. `T_refcam_lidar_initial`: tilt and position count, not the heading.
CalibrationResult calibrate_any_heading(std::span<const Scene> scenes,
                                        std::span<const RigCamera> cameras,
                                        const Eigen::Isometry3d& T_refcam_lidar_initial,
                                        const CalibrateOptions& options,
                                        const HeadingOptions& headings = {});

}  // namespace infuse::calibration
