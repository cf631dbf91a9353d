#pragma once

#include <array>
#include <optional>

#include "fusion/motion/gnss_position_check.hpp"
#include "fusion/motion/odometry_sources.hpp"
#include "fusion/motion/odometry_trajectory.hpp"
#include "fusion/motion/rate_delay.hpp"
#include "fusion/motion/sample_queue.hpp"
#include "fusion/motion/speed_arbiter.hpp"

namespace infuse::motion {

/// Estimated parameters and counters of the odometry filter.
struct OdometryReport {
  EstimatedParameter wheel_scale;               ///< true over measured speed
  EstimatedParameter yaw_rate_bias;             ///< rad/s, of `WheelOdometry::yaw_rate`
  std::array<EstimatedParameter, 3> gyro_bias;  ///< rad/s, of `ImuSample`; planar: z only
  EstimatedParameter steering_zero;             ///< rad at the steering wheel when driving straight
  EstimatedParameter steering_gain;             ///< road wheel angle over steering wheel angle
  /// s from measurement to stamp, beyond the options'.
  EstimatedParameter yaw_rate_delay, imu_delay, gnss_delay;
  double speed = 0;           ///< m/s along x
  double speed_sigma = 0;     ///< m/s, standard deviation of `speed`
  double yaw_rate_sigma = 0;  ///< rad/s, of the angular velocity about z
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  ///< rad/s, vehicle frame
  bool standing = false;                                       ///< the vehicle stands
  std::array<SourceRecord, kOdometrySources> sources;          ///< by `OdometrySource`
  std::array<bool, kOdometrySources> carries{};                ///< a sample was accepted recently
  uint64_t late = 0;             ///< samples older than the filter's time on arrival
  uint64_t outliers = 0;         ///< samples rejected as inconsistent with the motion
  uint64_t invalid_samples = 0;  ///< samples without a finite quantity, or with an isolated stamp
};

/// Dead reckoning in the odometry frame from what there is of wheel speeds, yaw rate, inertial
/// unit, steering, speed and course of a GNSS receiver and relative poses of the lidar. Samples may
/// arrive out of order by up to `reorder` and may be missing. While no source measures the speed,
/// or none the rotation, for longer than its maximum silence, the filter is unusable and the
/// trajectory has a gap.
///
/// Sources check each other: a sample that is inconsistent with the motion is rejected and counted.
/// Wheels that contradict another source of speed (they slip) are not used until they agree again.
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
  void add(const ImuSample& sample);        ///< as above
  void add(const AngularVelocity& sample);  ///< as above
  void add(const GnssFix& fix);             ///< as above

  /// Requests a pose of the trajectory at exactly this time and, with `clone`, a clone for a later
  /// `RelativePose`. As for samples, the time must not be before the filter's.
  void mark(Stamp stamp, bool clone);

  /// Processes samples and marks up to a time, without waiting for earlier ones.
  void process_until(Stamp until);

  /// Corrects the motion between two marks, and the trajectory from the first of them on.
  void add(const RelativePose& pose);

  /// Processes the samples that wait for earlier ones, at the end of a recording.
  void flush();

  /// Poses so far.
  const geometry::Trajectory& trajectory() const { return trajectory_.poses(); }

  /// Where the vehicle is now; while the filter is unusable, by the motion before and what is still
  /// measured, with a covariance that grows by what a vehicle can do unseen.
  geometry::PoseAt predicted_pose() const { return trajectory_.pose(state_); }

  /// Returns why the filter is unusable now, as static text; empty if it is usable.
  const char* reason() const;
  bool usable() const { return *reason() == '\0'; }  ///< there is no reason against it

  /// True if a sample of a source was accepted recently.
  bool carries(OdometrySource source) const { return sources_.carries(source, now_); }

  /// True while wheels measure how the vehicle moves, in a model that leaves no direction out.
  bool wheels_measure_motion() const { return wheels_measure_speed() && !options_.planar; }

  /// True while wheels, or what states the vehicle's speed instead, measure it.
  bool has_wheels() const {
    return carries(OdometrySource::kWheels) || carries(OdometrySource::kSpeed);
  }

  /// What is estimated, and what was left out.
  OdometryReport report() const;

 private:
  void insert(Stamp stamp, const SampleQueue::Sample& sample);
  void reset_clock();
  void advance(Duration ahead);
  void process(const SampleQueue::Entry& entry);
  void update(const WheelOdometry& sample);
  void update(const ImuSample& sample);
  void update(const AngularVelocity& sample);
  void update(const GnssFix& fix);
  void update(const PoseMark& mark);
  void update_gyro(const std::array<double, 3>& rate, double noise);
  EstimatedParameter delay_of(OdometrySource rates) const;
  void use_found(OdometrySource rates);
  void update_wheel_speeds(const WheelOdometry& sample);
  bool wheels_measure_speed() const {
    const auto measures = [&](OdometrySource source) {
      return carries(source) && !arbiter_.is_out(source);
    };
    return measures(OdometrySource::kWheels) || measures(OdometrySource::kSpeed);
  }
  void update_gnss_speed(double measured);
  void update_gnss_course(double course, double interval);
  void claim_speed(const RelativePose& pose, const RelativePoseUpdate& update, double state_speed);
  bool believe_lidar(const RelativePoseUpdate& update);
  void detect_standstill(bool at_rest);
  void record(OdometrySource source, bool accepted,
              void (OdometryState::*reset_covariance)() = nullptr);
  void extend_trajectory(Duration interval);  // since the last pose, at least

  OdometryOptions options_;
  OdometryState state_;
  OdometryTrajectory trajectory_;
  SampleQueue queue_;
  Stamp now_ = Stamp::earliest();
  OdometrySources sources_;
  SpeedArbiter arbiter_;
  GnssPositionCheck gnss_position_check_;
  /// What the last relative pose measured, accepted or not.
  struct LastRelativePose {
    Stamp to;
    geometry::Vector6 twist;  // per second
  };
  std::optional<LastRelativePose> last_relative_pose_;
  RateDelay yaw_rate_delay_, imu_delay_;
  Stamp last_gnss_speed_stamp_ = Stamp::earliest();
  Stamp last_course_stamp_ = Stamp::earliest();
  double course_doubt_ = 0;  // s of courses since one was accepted
  Stamp last_steering_stamp_ = Stamp::earliest();
  Stamp at_rest_since_ = Stamp::latest();
  std::optional<WheelOdometry> last_wheels_;
  uint64_t late_ = 0, outliers_ = 0, invalid_samples_ = 0;
};

}  // namespace infuse::motion
