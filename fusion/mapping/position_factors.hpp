#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fusion/mapping/optimize.hpp"

namespace infuse::mapping {

/// Settings of positions from GNSS.
struct PositionOptions {
  double sigma = 2.5;          ///< m, horizontal, of a fix with hdop 1 or less
  double vertical_factor = 2;  ///< of the height
  double spacing = 10;         ///< m driven between two fixes that count
  double correlation = 100;    ///< m driven, over which fixes err alike: each counts that much less
  double max_outlier_sigmas = 4;  ///< a fix further from the fitted poses does not count
  size_t min_fixes = 5;           ///< fewer give no georeference
  double min_extent = 10;    ///< m, root mean square of the fixes' distances from their mean; less
                             ///< gives no heading
  double min_inliers = 0.5;  ///< share of the fixes; fewer give no georeference

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

/// Poses that were fitted to positions.
struct PositionFit {
  OptimizeResult optimized;
  /// The graph with its first pose the origin of the map (the identity, held), from which edges
  /// with no information of the rotation lead to the keyframes; these follow.
  PoseGraph<3> graph;
  std::vector<char> accepted;           ///< by factor
  double rms = 0;                       ///< m, horizontal, of the accepted positions
  std::string reason = "no positions";  ///< empty if the poses are usable

  bool usable() const { return reason.empty(); }
};

/// Fits a graph of keyframes to positions: turns and moves it about the vertical by least squares,
/// then optimises its poses with both, without the positions that contradict (truncated least
/// squares). `options.invalid()` must be empty.
PositionFit fit_positions(const PoseGraph<3>& keyframes, const std::vector<PositionFactor>& factors,
                          const PositionOptions& options = {});

}  // namespace infuse::mapping
