#pragma once

#include <optional>

#include "drivers/measurement/sweep.hpp"
#include "fusion/features/air_returns.hpp"
#include "fusion/motion/deskew.hpp"
#include "fusion/registration/lidar_odometry.hpp"

namespace infuse::registration {

/// Follows a vehicle by the sweeps of one lidar and nothing else: deskews each at the velocity
/// before, registers it, deskews it again at the velocity found, and registers it once more.
/// Reference times are the middles of the sweeps. Returns of fog and snow are left out: the air
/// moves with nothing, but is always around the lidar, and would hold it back.
class LidarTrajectory {
 public:
  /// `options.invalid()` must be empty.
  explicit LidarTrajectory(const Eigen::Isometry3d& T_vehicle_lidar,
                           const LidarOdometryOptions& options = {});

  /// Processes the next sweep and returns what was found. The first sweep waits for the second,
  /// which shows how fast the vehicle was when it began. The guess is the motion between the
  /// middles of the sweep before and this one, which stays where the geometry leaves a direction
  /// free; without one the motion before is taken to continue.
  const LidarOdometryResult& add(const Sweep& sweep,
                                 const std::optional<Eigen::Isometry3d>& T_from_to_guess = {});

  /// Forgets map and motion: the next sweep is a first one.
  void reset();

  /// Pose of the vehicle at the end of the last sweep in the frame of the results' `T_map_vehicle`,
  /// at the mean of the velocities that were measured last: the error of a pose would count twice.
  Eigen::Isometry3d T_map_end() const;

  /// Returns the last sweep, deskewed to its middle.
  const motion::DeskewedSweep& deskewed() const { return deskewed_; }

 private:
  void deskew(const Sweep& sweep, const geometry::Vector6& velocity);
  void start(const Sweep& sweep, Stamp reference, std::optional<Eigen::Isometry3d> T_from_to);
  void follow(const Sweep& sweep, Stamp reference, const Eigen::Isometry3d& guess);
  /// The sweep deskewed last, whose returns of the air were found last.
  geometry::PointsView points() { return {air_.without(deskewed_.x), deskewed_.y, deskewed_.z}; }

  int max_lost_;
  motion::Deskewer deskewer_;
  LidarOdometry odometry_;
  geometry::Trajectory motion_;  // of the present sweep, at constant twist
  motion::DeskewedSweep deskewed_;
  features::AirReturns air_;
  Sweep first_;                                             // until the second comes
  bool waiting_ = false;                                    // for it
  int lost_ = 0;                                            // sweeps in a row without a motion
  geometry::Vector6 velocity_ = geometry::Vector6::Zero();  // twist per second, vehicle frame
  geometry::Vector6 velocity_before_ = geometry::Vector6::Zero();  // of the sweep before
  bool moving_ = false;                                            // velocity_ is known
  Stamp last_;
  Duration to_end_{0};  // from there to the end of the sweep
  LidarOdometryResult result_;
};

}  // namespace infuse::registration
