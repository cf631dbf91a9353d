#include "fusion/registration/lidar_odometry_options.hpp"

namespace infuse::registration {

std::optional<std::string> LidarOdometryOptions::invalid() const {
  if (auto wrong = map.invalid()) return wrong;
  if (!(min_range >= 0)) return "min_range must not be negative";
  if (!(map_voxel_size > 0 && match_voxel_size > 0 && min_match_voxel_size > 0))
    return "voxel sizes must be above 0 m";
  if (!(final_radius > 0 && final_radius <= radius && radius <= map.voxel_size))
    return "radii must be above 0 m, final_radius at most radius, radius at most map.voxel_size";
  if (!(robust_width > 0 && robust_width <= first_robust_width))
    return "robust_width must be above 0 and at most first_robust_width";
  if (max_iterations < 1) return "max_iterations must be at least 1";
  if (!(rotation_tolerance > 0 && translation_tolerance > 0)) return "tolerances must be above 0";
  if (!(max_start_speed >= 0 && max_start_speed <= 200))
    return "max_start_speed must be between 0 and 200";
  if (!(start_step > 0)) return "start_step must be above 0";
  if (max_failures < 1) return "max_failures must be at least 1";
  return std::nullopt;
}

}  // namespace infuse::registration
