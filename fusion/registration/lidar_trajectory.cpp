#include "fusion/registration/lidar_trajectory.hpp"

#include "fusion/motion/constant_motion.hpp"

namespace infuse::registration {
namespace {

constexpr int kStartPasses = 3;  // deskewing of the first two sweeps by their own motion

Stamp middle(const Sweep& sweep) { return sweep.stamp + sweep.span / 2; }

}  // namespace

LidarTrajectory::LidarTrajectory(const Eigen::Isometry3d& T_vehicle_lidar,
                                 const LidarOdometryOptions& options)
    : max_lost_(options.max_failures),
      deskewer_(T_vehicle_lidar),
      odometry_(T_vehicle_lidar, options),
      motion_({.capacity = 2, .max_gap = Duration(10'000'000'000)}) {}

void LidarTrajectory::deskew(const Sweep& sweep, const geometry::Vector6& velocity) {
  motion::set_constant_motion(sweep, middle(sweep), velocity, motion_);
  deskewer_.deskew(sweep, motion_, middle(sweep), deskewed_);
}

void LidarTrajectory::start(const Sweep& sweep, Stamp reference,
                            std::optional<Eigen::Isometry3d> T_from_to) {
  velocity_.setZero();
  for (int pass = 0; pass < kStartPasses; ++pass) {
    odometry_.reset();
    deskew(first_, velocity_);
    air_.find(first_);
    odometry_.add(points(), odometry_.align(points(), middle(first_)));
    deskew(sweep, velocity_);
    air_.find(sweep);
    result_ = odometry_.align(points(), reference, T_from_to);
    if (!result_.usable()) break;
    T_from_to = result_.motion.T_from_to;
    velocity_ = result_.velocity;
  }
}

const LidarOdometryResult& LidarTrajectory::add(
    const Sweep& sweep, const std::optional<Eigen::Isometry3d>& T_from_to_guess) {
  const Stamp reference = middle(sweep);
  air_.find(sweep);
  if (moving_) {
    const Eigen::Isometry3d same = geometry::exp(velocity_ * to_seconds(reference - last_));
    follow(sweep, reference, T_from_to_guess.value_or(same));
  } else if (waiting_ && (T_from_to_guess || lost_ % max_lost_ == 0)) {
    start(sweep, reference, T_from_to_guess);
  } else {
    result_ = {};
    result_.stamp = reference;
    result_.reason = "the first sweep waits for the next";
  }
  if (result_.usable()) {
    velocity_before_ = moving_ ? velocity_ : result_.velocity;
    velocity_ = result_.velocity;
    moving_ = true;
    waiting_ = false;
    lost_ = 0;
  } else if (!moving_ || ++lost_ >= max_lost_) {
    // The next sweep starts with this one. The search of a start costs a hundred registrations.
    if (moving_) reset();
    lost_ = waiting_ ? lost_ + 1 : 0;
    first_ = sweep;
    waiting_ = true;
  }
  if (moving_) odometry_.add(points(), result_);
  last_ = reference;
  to_end_ = sweep.span - sweep.span / 2;
  return result_;
}

// Deskewed at the velocity before, and again at the one that is found.
void LidarTrajectory::follow(const Sweep& sweep, Stamp reference, const Eigen::Isometry3d& guess) {
  deskew(sweep, velocity_);
  result_ = odometry_.align(points(), reference, guess);
  if (!result_.usable() && !result_.unsettled) return;
  deskew(sweep, result_.velocity);
  result_ = odometry_.align(points(), reference, result_.motion.T_from_to);
}

void LidarTrajectory::reset() {
  odometry_.reset();
  velocity_.setZero();
  moving_ = waiting_ = false;
  lost_ = 0;
}

Eigen::Isometry3d LidarTrajectory::T_map_end() const {
  return result_.T_map_vehicle *
         geometry::exp((velocity_ + velocity_before_) / 2 * to_seconds(to_end_));
}

}  // namespace infuse::registration
