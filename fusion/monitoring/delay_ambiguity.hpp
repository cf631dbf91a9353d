#pragma once

#include <optional>

#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/monitoring/axis.hpp"

namespace infuse::monitoring {

/// Motion of the vehicle during an exposure: a twist in camera axes.
struct Motion {
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();  ///< rad/s
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      ///< m/s
};

/// Check whether late stamps can be separated from a displaced camera. A camera that is late by τ
/// sees the world as one displaced by τ times the vehicle's twist. While the twist is constant both
/// look the same: in a steady turn a delay equals a yaw, at a steady speed a shift ahead. Only a
/// twist that changes between evaluations separates them.
class DelayAmbiguity {
 public:
  /// Adds the motion at an evaluation; older ones fade by 1/30 per evaluation.
  void add(const Motion& motion);

  /// Returns the axis along which a delay has the same effect; none if both can be separated.
  std::optional<Axis> axis() const;

 private:
  geometry::Vector6 mean_ = geometry::Vector6::Zero();  // of twists, in units of `drift_offset`
  double mean_square_ = 0;                              // of their squared norms
  double weight_ = 0;
};

}  // namespace infuse::monitoring
