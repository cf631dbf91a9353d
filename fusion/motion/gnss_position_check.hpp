#pragma once

#include <Eigen/Core>
#include <optional>

#include "drivers/measurement/vehicle_samples.hpp"
#include "fusion/motion/odometry_state.hpp"

namespace infuse::motion {

/// A doubted receiver is believed again after this time, ns (decision 17).
inline constexpr Duration kMaxGnssDoubt{60'000'000'000};

/// Compares the positions of a GNSS receiver with odometry: a fix must lie where odometry leads
/// from the last one that was believed. Positions are never used for the pose.
class GnssPositionCheck {
 public:
  /// Checks a fix at a pose. `east_heading` is the heading of the odometry frame; while it is
  /// uncertain, only distances are compared. Returns true if the fix lies where odometry leads,
  /// within the tolerance: it is then believed; nothing if there is nothing to compare with.
  std::optional<bool> check(const GnssFix& fix, const Eigen::Vector3d& position,
                            const EstimatedParameter& east_heading);

  void reset() { believed_.reset(); }

 private:
  struct Believed {
    Stamp stamp;
    double latitude = 0, longitude = 0;
    Eigen::Vector2d position;  // m, odometry frame
  };
  std::optional<Believed> believed_;
};

}  // namespace infuse::motion
