#pragma once

#include <optional>

#include "fusion/monitoring/drift_detector.hpp"

namespace infuse::monitoring {

/// How the vehicle moved while a picture was taken: a twist in camera axes.
struct Motion {
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();  ///< rad/s
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      ///< m/s
};

/// Whether late stamps can be told from a camera that moved. A camera that is late by τ sees the
/// world as one that is off by τ times the vehicle's twist: while the twist stays the same, so does
/// that, and a steady turn makes a delay look like a yaw, a steady speed like a shift ahead. Only
/// where the twist changes from look to look does a delay tell itself.
class DelayAmbiguity {
 public:
  /// The motion at a look. Late looks count, fading by 1/30 a look.
  void add(const Motion& motion);

  /// The axis along which a delay looks alike; none where the two can be told apart.
  std::optional<Axis> axis() const;

 private:
  geometry::Vector6 mean_ = geometry::Vector6::Zero();  // of twists, by what matters along an axis
  double mean_square_ = 0;                              // of their lengths
  double weight_ = 0;
};

}  // namespace infuse::monitoring
