#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/gyro_readings.hpp"
#include "fusion/motion/angular_velocity.hpp"
#include "fusion/motion/relative_pose.hpp"

namespace infuse::motion {

/// Settings of `GyroAxes`.
struct GyroAxesOptions {
  Duration memory{120'000'000'000};  ///< ns after which an interval counts 1/e (decision 17)
  double min_intervals = 30;         ///< fewer intervals of motion say nothing (decision 17)
  double min_lead = 20;  ///< nats by which an axis explains a gyro best: a wrong one leads so, by a
                         ///< likelihood ratio, at most one in 485 000 000 times
  double max_unexplained = 0.2;   ///< share of a gyro's variance its axis may leave (decision 17)
  double max_scale_error = 0.15;  ///< of a gyro against the lidar (decision 17)
  double max_missing = 0.1;  ///< share of an axis of the vehicle that gyros without a known axis
                             ///< may carry (decision 17)

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// What is known of one gyro.
struct GyroAxis {
  int axis = -1;     ///< of the lidar: 0 x, 1 y, 2 z; −1: not known
  double sign = 1;   ///< −1: it measures the rotation about the axis' opposite
  double bias = 0;   ///< rad/s, as of when the axis was found
  double noise = 0;  ///< rad/s, standard deviation of a reading
  const char* reason = "no motion was measured yet";  ///< static text: why it is not known; empty
                                                      ///< if it is

  bool known() const { return *reason == '\0'; }
};

/// Finds out which axis of the lidar each of three gyros in its housing measures, and with which
/// sign, by comparing their readings with the rotation that registration of its sweeps measures.
/// Each gyro is taken to measure one of the six signed axes with unit scale and an unknown bias, or
/// nothing. An axis is known once it explains the readings, and much better than the others do: a
/// vehicle that has only turned shows the gyro about z. Does not allocate after construction.
class GyroAxes {
 public:
  /// `options.invalid()` must be empty.
  explicit GyroAxes(const Eigen::Matrix3d& R_vehicle_lidar, const GyroAxesOptions& options = {});

  /// Adds readings, in order of time.
  void add(const GyroReadings& readings);

  /// Adds the vehicle's motion between two times that the readings cover.
  void add(const RelativePose& motion);

  /// The angular velocity of the vehicle by the gyros whose axes are known, NaN where none is.
  /// Nothing while that about z is not known.
  std::optional<AngularVelocity> measure(const GyroReadings& readings) const;

  const std::array<GyroAxis, 3>& axes() const { return axes_; }

 private:
  using Vector = Eigen::Matrix<double, 6, 1>;  // rotation of the lidar, then the three gyros

  bool mean_readings(Stamp from, Stamp to, Eigen::Vector3d& mean, Eigen::Vector3d& scatter,
                     double& count) const;
  double unexplained(int gyro, int axis, double sign) const;
  bool contradicted(int gyro, const GyroAxis& known) const;
  GyroAxis judge(int gyro) const;

  Eigen::Matrix3d R_vehicle_lidar_;
  GyroAxesOptions options_;
  std::vector<GyroReadings> readings_;  // ring of the latest
  size_t next_ = 0;
  Stamp last_ = Stamp::earliest();  // end of the last interval
  double weight_ = 0;               // of the intervals
  Vector mean_ = Vector::Zero();
  Eigen::Matrix<double, 6, 6> scatter_ = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Vector3d within_ = Eigen::Vector3d::Zero();  // mean variance within an interval
  double per_interval_ = 0;                           // mean number of readings
  std::array<GyroAxis, 3> axes_;
};

}  // namespace infuse::motion
