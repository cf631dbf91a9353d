#include "daemon/pipeline/lidar_motion.hpp"

#include "fusion/motion/constant_motion.hpp"

namespace infuse::daemon {
namespace {

/// True if a predicted motion would deskew a sweep visibly wrong.
bool is_wrong(const Eigen::Isometry3d& predicted, const Eigen::Isometry3d& measured) {
  constexpr double kRotation = 1e-3, kTranslation = 0.01;  // rad, m
  const geometry::Vector6 error = geometry::log(predicted.inverse() * measured);
  return error.head<3>().norm() > kRotation || error.tail<3>().norm() > kTranslation;
}

/// True if a predicted motion is a better guess than that the motion before continues: after a
/// start at speed, odometry extrapolates what one sweep has shown.
bool is_known(const geometry::Matrix6& covariance) {
  constexpr double kMaxSigma = 0.3;  // m
  return covariance.block<3, 3>(3, 3).diagonal().maxCoeff() < kMaxSigma * kMaxSigma;
}

}  // namespace

LidarMotion::LidarMotion(const Eigen::Isometry3d& T_vehicle_lidar)
    : lidar_odometry_(T_vehicle_lidar),
      measured_motion_({.capacity = 2, .max_gap = Duration(10'000'000'000)}),
      lidar_trajectory_(T_vehicle_lidar) {}

void LidarMotion::restart() {
  if (lidar_odometry_.map_voxels() > 0) lidar_odometry_.reset();
  followed_.reset();
  last_registered_ = Stamp::earliest();
  map_deskewed_ = false;
}

// Wheels that slip for a moment, or come now and then, change nothing: each change begins a map.
bool LidarMotion::by_wheels(bool has_wheels, Stamp now) {
  constexpr Duration kChangeAfter{2'000'000'000};
  if (!by_wheels_) by_wheels_ = has_wheels;
  other_since_ = has_wheels == *by_wheels_ ? Stamp::latest() : std::min(other_since_, now);
  if (other_since_ != Stamp::latest() && now - other_since_ >= kChangeAfter) {
    by_wheels_ = has_wheels;
    other_since_ = Stamp::latest();
  }
  return *by_wheels_;
}

// The velocity is that of the time between the last two middles: both ends lag alike where it
// changes evenly. A first motion is at the velocity between the middles. The prediction counts only
// where the geometry leaves a direction free.
std::optional<motion::RelativePose> LidarMotion::follow(const Sweep& sweep,
                                                        const geometry::Trajectory& predicted,
                                                        Stamp end) {
  constexpr Duration kMaxGap{1'000'000'000};
  if (followed_ && !(end > followed_->stamp && end - followed_->stamp < kMaxGap)) followed_.reset();
  if (!followed_) lidar_trajectory_.reset();
  const std::optional<End> last = followed_;
  if (lidar_odometry_.map_voxels() > 0) lidar_odometry_.reset();
  map_deskewed_ = false;
  const Stamp middle = sweep.stamp + sweep.span / 2;
  std::optional<Eigen::Isometry3d> guess;
  if (last) {
    const geometry::MotionBetween motion = predicted.between(last->middle, middle);
    if (motion.usable() && is_known(motion.covariance)) guess = motion.T_from_to;
  }
  const registration::LidarOdometryResult& result = lidar_trajectory_.add(sweep, guess);
  followed_ = End{end, middle, std::nullopt};
  if (!result.usable()) return std::nullopt;
  followed_->T_map_vehicle = lidar_trajectory_.T_map_end();
  if (!last || result.motion.information.isZero()) return std::nullopt;
  const motion::RelativePose& middles = result.motion;
  motion::RelativePose motion = middles;
  motion.from = last->stamp;
  motion.to = end;
  if (last->T_map_vehicle) {
    motion.T_from_to = last->T_map_vehicle->inverse() * *followed_->T_map_vehicle;
  } else {
    const double share = to_seconds(end - last->stamp) / to_seconds(middles.to - middles.from);
    motion.T_from_to = geometry::exp(share * geometry::log(middles.T_from_to));
  }
  return motion;
}

LidarMotion::Found LidarMotion::align(const Sweep& sweep, const OdometryTracker& odometry,
                                      motion::Deskewer& deskewer, motion::DeskewedSweep& deskewed) {
  const Stamp end = deskewed.reference;
  const geometry::MotionBetween motion = odometry.trajectory().between(last_registered_, end);
  std::optional<Eigen::Isometry3d> guess;
  if (motion.usable()) guess = motion.T_from_to;
  // What the lidar itself predicts would come back as measured.
  const bool measured = motion.usable() && odometry.wheels_measure_motion();
  const geometry::MotionBetween* prior = measured ? &motion : nullptr;
  last_registered_ = end;
  if (deskewed.usable() && !map_deskewed_) lidar_odometry_.reset();
  Found found;
  air_.find(sweep);
  found.result = lidar_odometry_.align(points(deskewed), end, guess, prior);
  found.wrong = (found.result.usable() || found.result.unsettled) && guess &&
                is_wrong(*guess, found.result.motion.T_from_to);
  if (found.wrong) {
    motion::set_constant_motion(sweep, end, found.result.velocity, measured_motion_);
    deskewer.deskew(sweep, measured_motion_, end, deskewed);
    found.result =
        lidar_odometry_.align(points(deskewed), end, found.result.motion.T_from_to, prior);
  }
  found.measured = found.result.usable() && !found.result.motion.information.isZero();
  return found;
}

void LidarMotion::take(const Found& found, bool predicted, const motion::DeskewedSweep& deskewed) {
  if (!predicted && !map_deskewed_ && deskewed.usable()) lidar_odometry_.reset();
  lidar_odometry_.add(points(deskewed), found.result);
  map_deskewed_ = deskewed.usable();
}

}  // namespace infuse::daemon
