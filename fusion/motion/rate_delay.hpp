#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "drivers/measurement/stamp.hpp"
#include "fusion/motion/relative_pose.hpp"

namespace infuse::motion {

/// How late the stamps of a sensor are.
struct SensorDelay {
  double value = 0;         ///< s from measurement to stamp
  double sigma = 0;         ///< s, standard deviation
  const char* reason = "";  ///< static text: why it is not usable; empty if it is

  bool usable() const { return *reason == '\0'; }  ///< it may be used
};

/// Finds how late a sensor of angular rates is, by the rotations that a lidar measures: the delay
/// at which the sensor's rates, linear between samples, explain them best in the last two minutes,
/// each axis with a bias and a noise of its own (maximum likelihood). Each sensor is compared with
/// the lidar alone, never with what another one was fused into.
class RateDelay {
 public:
  /// Allocates all memory.
  RateDelay();

  /// Adds a sample, rad/s in vehicle axes; NaN: an axis that is not measured. In order of time.
  void add(Stamp stamp, const Eigen::Vector3d& rate);
  /// Adds a motion of which the lidar measured the rotation. It may be before or after the samples.
  void add(const RelativePose& motion);
  /// Forgets samples and motions that wait for samples, after a step of the clock.
  void reset();

  /// What was found last; it stays while the vehicle drives straight on.
  const SensorDelay& found() const { return found_; }
  /// True if a delay was found, or refuted, since the last call.
  bool newly_found() { return std::exchange(is_new_, false); }
  /// What was found, with the last second: at the end of a recording.
  const SensorDelay& finish();
  /// rad/s², of the last tenths of a second before `stamp`; an axis that is not measured, or after
  /// a gap: 0.
  Eigen::Vector3d change_before(Stamp stamp) const;
  /// s between samples, on average over about the last twenty; gaps are left out.
  double interval() const { return interval_; }

 private:
  static constexpr int kSteps = 25;  // either way: 0.25 s; bounds the work
  static constexpr Eigen::Index kCandidates = 2 * kSteps + 1;
  /// Angles that the sensor measured until a time.
  struct Angle {
    Stamp stamp;
    Eigen::Vector3d rate, sum;
  };
  /// Sums of the errors in a second: mean rates of motions beside those of the sensor, by
  /// candidate of the delay (the last: the sensor measures nothing).
  struct Block {
    Stamp begin;
    double count = 0;
    Eigen::Array<double, 3, kCandidates + 1> sum, squares;
  };
  using Rates = Eigen::Array3d;
  using Costs = Eigen::Array<double, kCandidates + 1, 1>;

  const Angle& angle(size_t i) const;           // of the ring, from the oldest
  Eigen::Vector3d angle_at(Stamp stamp) const;  // of a time within the ring
  void compare_waiting();
  void compare(const RelativePose& motion);
  void next_block(Stamp begin);
  void find();
  static Rates variance_of(const Block& total, Eigen::Index candidate);
  static double spread(const Costs& costs, Eigen::Index best, double value);
  double sigma_at(Eigen::Index best, double offset, const Block& total) const;

  std::vector<Angle> angles_;  // ring
  size_t newest_ = 0, angle_count_ = 0;
  std::vector<RelativePose> waiting_;
  std::vector<Block> blocks_;  // ring; the newest is being summed
  size_t block_ = 0;
  Eigen::Vector3d slow_rate_ = Eigen::Vector3d::Zero(), change_ = Eigen::Vector3d::Zero();
  double interval_ = 0;
  SensorDelay found_;
  bool is_new_ = false;
};

}  // namespace infuse::motion
