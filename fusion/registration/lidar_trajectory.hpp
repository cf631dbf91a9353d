#pragma once

#include <optional>

#include "drivers/measurement/sweep.hpp"
#include "fusion/motion/deskew.hpp"
#include "fusion/registration/lidar_odometry.hpp"

namespace infuse::registration {

/// Follows a vehicle by the sweeps of one lidar and nothing else: deskews each at the velocity
/// before, registers it, deskews it again at the velocity found, and registers it once more.
/// Reference times are the middles of the sweeps.
class LidarTrajectory {
 public:
  /// `options.invalid()` must be empty.
  explicit LidarTrajectory(const Eigen::Isometry3d& T_vehicle_lidar,
                           const LidarOdometryOptions& options = {});

  /// Processes the next sweep and returns what was found. The first sweep waits for the second,
  /// which shows how fast the vehicle was when it began.
  const LidarOdometryResult& add(const Sweep& sweep);

  /// Forgets all: the next sweep is a first one.
  void reset();

  /// Pose of the vehicle at the end of the last sweep in the frame of the results' `T_map_vehicle`,
  /// at the mean of the velocities that were measured last: the error of a pose would count twice.
  Eigen::Isometry3d T_map_end() const;

  /// Returns the last sweep, deskewed to its middle.
  const motion::DeskewedSweep& deskewed() const { return deskewed_; }

 private:
  void deskew(const Sweep& sweep, const geometry::Vector6& velocity);
  void start(const Sweep& sweep, Stamp reference);
  geometry::PointsView points() const { return {deskewed_.x, deskewed_.y, deskewed_.z}; }

  motion::Deskewer deskewer_;
  LidarOdometry odometry_;
  geometry::Trajectory motion_;  // of the present sweep, at constant twist
  motion::DeskewedSweep deskewed_;
  std::optional<Sweep> first_;                              // until the second comes
  geometry::Vector6 velocity_ = geometry::Vector6::Zero();  // twist per second, vehicle frame
  geometry::Vector6 velocity_before_ = geometry::Vector6::Zero();  // of the sweep before
  bool moving_ = false;                                            // velocity_ is known
  Stamp last_;
  Duration to_end_{0};  // from there to the end of the sweep
  LidarOdometryResult result_;
};

}  // namespace infuse::registration
