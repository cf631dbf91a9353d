#pragma once

#include <optional>
#include <span>

#include "fusion/mapping/keyframes.hpp"
#include "fusion/mapping/submap.hpp"

namespace infuse::mapping {

/// Keyframe with the cloud of the sweeps from it to the next one.
struct KeyframeSubmap {
  Keyframe keyframe;
  Submap submap;  ///< lidar frame of the keyframe
};

/// Turns deskewed sweeps and what odometry states about them into keyframes with submaps.
class KeyframeSubmaps {
 public:
  /// The options' `invalid()` must be empty.
  KeyframeSubmaps(const KeyframeOptions& keyframes, const SubmapOptions& submaps,
                  const Eigen::Isometry3d& T_vehicle_lidar)
      : T_vehicle_lidar_(T_vehicle_lidar), picker_(keyframes), builder_(submaps) {}

  /// Adds a sweep (lidar frame, m). Returns the keyframe that ends where this sweep begins the next
  /// one. A sweep that fits nowhere would blur the submap: it is added only where the lidar
  /// measured its motion, or where it is a keyframe.
  std::optional<KeyframeSubmap> add(const geometry::PointsView& points,
                                    std::span<const float> reflectivity, const SweepMotion& motion);

  /// Returns the present keyframe with its submap so far, which begins anew. There must be one.
  KeyframeSubmap take() { return {picker_.last(), builder_.take()}; }

  const KeyframePicker& picker() const { return picker_; }
  /// Number of sweeps added since the present keyframe, with its own.
  size_t sweeps() const { return sweeps_; }

 private:
  Eigen::Isometry3d T_vehicle_lidar_;
  KeyframePicker picker_;
  SubmapBuilder builder_;
  size_t sweeps_ = 0;
};

}  // namespace infuse::mapping
