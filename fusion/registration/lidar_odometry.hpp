#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fusion/geometry/trajectory.hpp"
#include "fusion/motion/relative_pose.hpp"
#include "fusion/registration/registration_result.hpp"
#include "fusion/registration/voxel_downsample.hpp"
#include "fusion/registration/voxel_map.hpp"

namespace infuse::registration {

/// Settings of the lidar odometry.
struct LidarOdometryOptions {
  VoxelMapOptions map;
  double min_range = 2.5;              ///< m; nearer returns are the vehicle's own
  double map_voxel_size = 0.25;        ///< m; a sweep adds one point per voxel to the map
  double match_voxel_size = 1.5;       ///< m; a sweep is registered by one point per voxel …
  size_t min_match_points = 2000;      ///< … or per smaller voxel until there are so many,
  double min_match_voxel_size = 0.25;  ///< m; but not below that
  double radius = 1.0;        ///< m; planes of the map are fitted to points within it, at first …
  double final_radius = 0.6;  ///< m; … and in the last iterations
  double robust_width = 0.1;  ///< m; distance from its plane at which a point counts a quarter
  double first_robust_width = 0.5;  ///< m; the same in the first iteration
  int max_iterations = 20;
  double rotation_tolerance = 1e-4;     ///< rad; a step smaller than both tolerances is the last
  double translation_tolerance = 1e-3;  ///< m
  size_t min_inliers = 100;             ///< fewer points on planes give no pose
  double min_plane_fraction = 0.01;     ///< as in `GicpOptions`
  double max_start_speed = 60;          ///< m/s; speeds that are tried when nothing is known
  double start_step = 0.8;              ///< m between the guesses at the start
  int max_failures = 5;                 ///< sweeps without a pose after which the map is begun anew

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

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

  bool usable() const { return *reason == '\0'; }
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
  RegistrationResult register_points(const Eigen::Isometry3d& T_map_lidar_guess, int max_iterations,
                                     bool final, const geometry::MotionBetween* prior = nullptr);

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
    double weight = 0;  // of the points on planes of the map
  };
  std::vector<Start> starts_;

  VoxelDownsampler downsampler_;
  PointCloud thinned_, selected_;
  Pairs pairs_;
  FieldVector<float> searched_x_, searched_y_, searched_z_;
  std::vector<int32_t> which_;
  std::vector<geometry::Vector6> clusters_;
  double overlap_ = 0;
};

}  // namespace infuse::registration
