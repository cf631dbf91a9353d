#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fusion/geometry/trajectory.hpp"
#include "fusion/motion/relative_pose.hpp"
#include "fusion/registration/map_registration.hpp"
#include "fusion/registration/voxel_downsample.hpp"

namespace infuse::registration {

/// What the odometry states about one sweep.
struct LidarOdometryResult {
  Stamp stamp;  ///< the sweep's reference time
  /// Pose of the vehicle in the frame of the local map: that of the vehicle at the first sweep.
  Eigen::Isometry3d T_map_vehicle = Eigen::Isometry3d::Identity();
  /// Motion since the sweep before, between the vehicle frames at both reference times. Its
  /// covariance is the sum of both sweeps' against the map: what the map itself drifts by, a part
  /// in a thousand of the way, is not in it. After a sweep without a pose it has no information:
  /// it would be a motion from a guess.
  motion::RelativePose motion;
  /// Mean velocity since the last sweep with a pose, vehicle frame: rad/s, m/s. That of the guess,
  /// or zero, where the result is neither usable nor unsettled.
  geometry::Vector6 velocity = geometry::Vector6::Zero();
  RegistrationResult registration;  ///< of the lidar to the map, about the lidar's position, in the
                                    ///< map's axes
  double overlap = 0;               ///< fraction of the points that lie on planes of the map
  const char* reason = "no sweep was given";  ///< static text; empty if `motion` is usable
  /// The registration still moved at the end, on points of which many lie on planes of the map: the
  /// motion is not usable, but closer than the guess. Deskewing by it and aligning again may help.
  bool unsettled = false;

  bool usable() const { return *reason == '\0'; }  ///< it may be used
};

/// Odometry from a lidar alone: each sweep is registered to a local map of the sweeps before
/// (P 4.2, point to plane). Points off their planes, such as those of moving objects, count less.
/// Does not allocate once it has seen sweeps of that size.
class LidarOdometry {
 public:
  /// `options.invalid()` must be empty.
  explicit LidarOdometry(const Eigen::Isometry3d& T_vehicle_lidar,
                         const LidarOdometryOptions& options = {});

  /// Registers a sweep that is deskewed to `reference` (coordinates in the lidar frame at that
  /// time). The guess is the vehicle's motion since the sweep before; without one the motion before
  /// is taken to continue, and the first pair of a map tries all speeds up to `max_start_speed`.
  /// `prior`, null or usable, is that motion as measured by other sensors: what the geometry hardly
  /// shows stays near it. The result's information is that of the lidar alone, although its pose
  /// keeps to the prior by the share that the prior has in it. After a sweep without a pose there
  /// is no prior. Changes nothing: `add` takes the sweep into the map.
  LidarOdometryResult align(const geometry::PointsView& points, Stamp reference,
                            const std::optional<Eigen::Isometry3d>& T_from_to_guess = {},
                            const geometry::MotionBetween* prior = nullptr);

  /// Takes a sweep into the map at its pose, deskewed to the same time, possibly better than for
  /// `align`. If the result is not usable, the vehicle is taken to have followed the guess, or an
  /// estimate that was unsettled, and the map is left as it is unless that happens repeatedly.
  void add(const geometry::PointsView& points, const LidarOdometryResult& result);

  /// Forgets map and motion.
  void reset();

  /// Voxels of the map.
  size_t map_voxels() const { return map_.voxels(); }

 private:
  void select(const geometry::PointsView& points, double voxel_size, size_t min_points);
  Eigen::Isometry3d predict(Stamp reference) const;
  Eigen::Isometry3d search_start(double seconds);
  std::optional<PosePrior> anchored(const geometry::MotionBetween* prior,
                                    const Eigen::Isometry3d& T_map_lidar_guess) const;

  Eigen::Isometry3d T_vehicle_lidar_;
  LidarOdometryOptions options_;
  VoxelMap map_;
  int sweeps_ = 0;    // that the map was made from
  int failures_ = 0;  // in a row
  Stamp stamp_;       // of the last sweep
  Eigen::Isometry3d T_map_vehicle_ = Eigen::Isometry3d::Identity();
  Stamp located_stamp_;  // of the last sweep with a pose
  Eigen::Isometry3d T_map_located_ = Eigen::Isometry3d::Identity();
  double usual_overlap_ = 0;                                  // rises fast, falls slowly
  geometry::Matrix6 covariance_ = geometry::Matrix6::Zero();  // as the last registration's
  geometry::Vector6 velocity_ = geometry::Vector6::Zero();    // twist per second, vehicle frame

  /// One of the speeds that are tried at the start.
  struct Start {
    Eigen::Isometry3d T_from_to;
    FieldVector<float> weights;  // of the points on planes of the map
    double weight = 0;           // their sum
  };
  std::vector<Start> starts_;

  VoxelDownsampler downsampler_;
  PointCloud thinned_, selected_;
  MapRegistration registration_;
};

}  // namespace infuse::registration
