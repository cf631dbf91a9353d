#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/angles.hpp"
#include "fusion/mapping/optimize.hpp"
#include "fusion/mapping/pose_graph.hpp"

namespace infuse::mapping {

/// Settings of the fit of a map to the earth: positions from GNSS, and roads, which are nearly
/// level.
struct EarthFitOptions {
  double sigma = 2.5;          ///< m, horizontal, of a fix with hdop 1 or less
  double vertical_factor = 2;  ///< of the height
  double spacing = 10;         ///< m driven between two fixes that count
  double correlation = 100;    ///< m driven, over which fixes err alike: each counts that much less
  double max_outlier_sigmas = 4;  ///< a fix further from the fitted poses does not count: one
                                  ///< in 16 000 of a Gaussian
  size_t min_fixes = 5;           ///< fewer give no georeference
  double min_extent = 10;    ///< m, root mean square of the fixes' distances from their mean; less
                             ///< gives no heading
  double min_inliers = 0.5;  ///< share of the fixes: most by definition
  /// Standard deviations of a road's slope across and along the vehicle. Drainage takes a crossfall
  /// of 2.5 % (RAS-Q, AASHTO), roads in towns climb by 6 % at most and mostly by half of that.
  double roll_sigma = 1.4 * kDegree;
  double pitch_sigma = 1.7 * kDegree;
  double slope_correlation = 1000;  ///< m driven, over which slopes are alike

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Measured position of a point that is fixed to a keyframe.
struct PositionFactor {
  size_t pose = 0;                                     ///< index of the keyframe
  Eigen::Vector3d point = Eigen::Vector3d::Zero();     ///< m, in the keyframe's vehicle frame
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< m, map frame
  Eigen::Vector3d sigma = Eigen::Vector3d::Ones();     ///< m
};

/// Poses in a frame that is upright, and where there are positions east-north-up.
struct EarthFit {
  OptimizeResult optimized;
  /// The graph with its first pose the origin of the map (the identity, held), from which edges
  /// lead to the keyframes: of their slope, and of positions, or of the place and heading of the
  /// first keyframe. These follow.
  PoseGraph<3> graph;
  std::vector<char> accepted;  ///< by factor
  double rms = 0;              ///< m, horizontal, of the accepted positions
  double tilt_sigma = 0;       ///< rad, of the vertical at the keyframe where it is known least
  std::string position_reason = "no positions";  ///< empty if the positions are in the fit

  /// Whether the poses may be used; `optimized.reason` says why not.
  bool usable() const { return optimized.usable(); }
  bool georeferenced() const { return usable() && position_reason.empty(); }
};

/// Fits a graph of keyframes, vehicle frames whose z axis is up on level ground, to the earth:
/// turns and moves it about the vertical by least squares over the positions, then optimises its
/// poses with both, without the positions that contradict (truncated least squares). Positions
/// along a line leave the roll about it free; there the roads' slope decides, and `tilt_sigma` says
/// how well. `options.invalid()` must be empty.
EarthFit fit_to_earth(const PoseGraph<3>& keyframes, const std::vector<PositionFactor>& factors,
                      const EarthFitOptions& options = {});

}  // namespace infuse::mapping
