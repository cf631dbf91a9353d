#include "fusion/mapping/keyframe_submaps.hpp"

namespace infuse::mapping {

std::optional<KeyframeSubmap> KeyframeSubmaps::add(const geometry::PointsView& points,
                                                   std::span<const float> reflectivity,
                                                   const SweepMotion& motion) {
  const std::optional<Keyframe> before =
      picker_.started() ? std::optional(picker_.last()) : std::nullopt;
  const bool is_keyframe = picker_.add(motion);
  if (!picker_.started()) return std::nullopt;
  std::optional<KeyframeSubmap> ended;
  if (is_keyframe) {
    if (before) ended = KeyframeSubmap{*before, builder_.take()};
    sweeps_ = 0;
  }
  if (motion.registered || is_keyframe) {
    const Eigen::Isometry3d T_keyframe_vehicle =
        picker_.last().T_odom_vehicle.inverse() * picker_.T_odom_vehicle();
    builder_.add(points, reflectivity,
                 T_vehicle_lidar_.inverse() * T_keyframe_vehicle * T_vehicle_lidar_);
    ++sweeps_;
  }
  return ended;
}

}  // namespace infuse::mapping
