#pragma once

#include <optional>
#include <string>

#include "fusion/registration/gauss_newton.hpp"
#include "fusion/registration/lengths.hpp"
#include "fusion/registration/voxel_map.hpp"

namespace infuse::registration {

/// Settings of the lidar odometry.
struct LidarOdometryOptions {
  VoxelMapOptions map;                    ///< the local map
  double min_range = kMinRange;           ///< m; nearer returns are the vehicle's own
  double map_voxel_size = kMapVoxelSize;  ///< m; a sweep adds one point per voxel to the map
  double match_voxel_size = 1.5;   ///< m; a sweep has one point per voxel (Vizzo et al. 2023) …
  size_t min_match_points = 2000;  ///< … or per smaller voxel until there are so many,
  double min_match_voxel_size = kMapVoxelSize;   ///< m; but not below that
  double radius = VoxelMapOptions{}.voxel_size;  ///< m; planes are fitted to points within it …
  double final_radius = 0.6;                     ///< m; … and in the last iterations within this
  double robust_width = 0.1;  ///< m; distance from its plane at which a point counts a quarter
  double first_robust_width = 0.5;   ///< m; the same in the first iteration
  int max_iterations = 20;           ///< of a sweep; bounds time
  double rotation_tolerance = 1e-4;  ///< rad; a step smaller than both tolerances is the last
  double translation_tolerance = StepLimits{}.translation_tolerance;  ///< m
  size_t min_inliers = 100;  ///< fewer points on planes give no pose
  double min_plane_fraction = StepLimits{}.min_plane_fraction;  ///< of the points' displacement
  double max_start_speed = 60;  ///< m/s; speeds that are tried when nothing is known
  double start_step = 0.8;      ///< m between the guesses at the start
  int max_failures = 5;         ///< sweeps without a pose after which the map is begun anew

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

}  // namespace infuse::registration
