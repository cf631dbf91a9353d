#pragma once

#include <array>
#include <optional>
#include <variant>
#include <vector>

#include "fusion/geometry/trajectory.hpp"
#include "fusion/motion/odometry_state.hpp"

namespace infuse::motion {

/// Estimated parameters and counters of the odometry filter.
struct OdometryReport {
  EstimatedParameter wheel_scale;               ///< true over measured speed
  EstimatedParameter yaw_rate_bias;             ///< rad/s, of `WheelOdometry::yaw_rate`
  std::array<EstimatedParameter, 3> gyro_bias;  ///< rad/s, of `ImuSample`; planar: z only
  EstimatedParameter steering_zero;             ///< rad at the steering wheel when driving straight
  double speed = 0;                             ///< m/s along x
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  ///< rad/s, vehicle frame
  bool standing = false;
  uint64_t late = 0;             ///< samples older than the filter's time on arrival
  uint64_t outliers = 0;         ///< samples rejected as inconsistent with the motion
  uint64_t invalid_samples = 0;  ///< samples without a finite quantity, or with an isolated stamp
};

/// Dead reckoning in the odometry frame from wheel speeds, yaw rate, inertial unit, steering and,
/// where available, the speed and course of a GNSS receiver. Samples may arrive out of order by up
/// to `reorder` and may be missing. If speed or rotation have no valid sample for `max_silence`,
/// the filter is unusable and the trajectory has a gap.
class OdometryFilter {
 public:
  /// `options.invalid()` must be empty. Allocates all memory.
  explicit OdometryFilter(const OdometryOptions& options = {},
                          const geometry::TrajectoryOptions& trajectory = {});

  /// Sets the current pose of the vehicle in the odometry frame. Without it, dead reckoning starts
  /// at the identity with zero covariance.
  void set_pose(const Eigen::Isometry3d& T_odom_vehicle, const geometry::Matrix6& covariance);

  /// Adds a sample; samples come roughly in time order.
  void add(const WheelOdometry& sample);
  void add(const ImuSample& sample);
  void add(const GnssFix& fix);

  /// Processes the samples that wait for earlier ones, at the end of a recording.
  void flush();

  /// Poses so far.
  const geometry::Trajectory& trajectory() const { return trajectory_; }

  /// Returns why the filter is unusable now, as static text; empty if it is usable.
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
  std::vector<PendingSample> pending_;  // in time order
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
