#pragma once

#include <array>
#include <optional>
#include <variant>
#include <vector>

#include "fusion/geometry/trajectory.hpp"
#include "fusion/motion/odometry_state.hpp"

namespace infuse::motion {

/// What the filter has learned of the vehicle's sensors.
struct OdometryReport {
  EstimatedParameter wheel_scale;               ///< true over measured speed
  EstimatedParameter yaw_rate_bias;             ///< rad/s, of `WheelOdometry::yaw_rate`
  std::array<EstimatedParameter, 3> gyro_bias;  ///< rad/s, of `ImuSample`; planar: z only
  EstimatedParameter steering_zero;             ///< rad at the steering wheel, driving straight
  double speed = 0;                             ///< m/s along x
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  ///< rad/s, vehicle frame
  bool standing = false;
  uint64_t late = 0;             ///< samples that came after their time had been worked off
  uint64_t outliers = 0;         ///< samples that did not agree with the motion and were not used
  uint64_t invalid_samples = 0;  ///< samples with no finite quantity, or one stamp apart from all
};

/// Dead reckoning from wheel speeds, yaw rate, inertial unit, steering and, where there is one, a
/// receiver's speed and course. Samples may come out of order by `reorder` and may be missing;
/// where speed or rotation are silent or contradicted for `max_silence` the filter is not trusted,
/// and the trajectory has a gap.
class OdometryFilter {
 public:
  /// `options.invalid()` must be empty. All memory is taken here.
  explicit OdometryFilter(const OdometryOptions& options = {},
                          const geometry::TrajectoryOptions& trajectory = {});

  /// Says where the vehicle is now, as the start of dead reckoning. Without it, it starts at the
  /// identity, perfectly known.
  void set_pose(const Eigen::Isometry3d& T_odom_vehicle, const geometry::Matrix6& covariance);

  /// Samples, in about their order of time.
  void add(const WheelOdometry& sample);
  void add(const ImuSample& sample);
  void add(const GnssFix& fix);

  /// Works off the samples that still wait for earlier ones, at the end of a recording.
  void flush();

  /// The poses so far.
  const geometry::Trajectory& trajectory() const { return trajectory_; }

  /// Why the filter cannot be trusted now, static text; empty where it can.
  const char* reason() const;
  bool usable() const { return *reason() == '\0'; }

  OdometryReport report() const;

 private:
  using Sample = std::variant<WheelOdometry, ImuSample, GnssFix>;
  struct PendingSample {
    Stamp stamp;
    Sample sample;
  };

  void insert(Stamp stamp, const Sample& sample);
  void reset_clock();
  void process_until(Stamp until);
  void process(const PendingSample& waiting);
  void update(const WheelOdometry& sample);
  void update(const ImuSample& sample);
  void update(const GnssFix& fix);
  void detect_standstill(const WheelOdometry& sample);
  void handle_gate_result(bool accepted, Stamp& last_accepted,
                          void (OdometryState::*reset_covariance)());
  void extend_trajectory();

  OdometryOptions options_;
  OdometryState state_;
  geometry::Trajectory trajectory_;
  std::vector<PendingSample> pending_;  // in order of time
  Stamp now_ = Stamp::earliest();
  Stamp newest_stamp_ = Stamp::earliest();
  std::optional<Stamp> jumped_stamp_;
  Stamp last_speed_stamp_ = Stamp::earliest();
  Stamp last_rotation_stamp_ = Stamp::earliest();
  Stamp last_steering_stamp_ = Stamp::earliest();
  Stamp at_rest_since_ = Stamp::latest();
  uint64_t late_ = 0, outliers_ = 0, invalid_samples_ = 0;
};

}  // namespace infuse::motion
