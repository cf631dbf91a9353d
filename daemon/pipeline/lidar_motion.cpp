#include "daemon/pipeline/lidar_motion.hpp"

#include "fusion/motion/constant_motion.hpp"

namespace infuse::daemon {
namespace {

geometry::PointsView points_of(const motion::DeskewedSweep& deskewed) {
  return {deskewed.x, deskewed.y, deskewed.z};
}

/// True if a predicted motion would deskew a sweep visibly wrong.
bool is_wrong(const Eigen::Isometry3d& predicted, const Eigen::Isometry3d& measured) {
  constexpr double kRotation = 1e-3, kTranslation = 0.01;  // rad, m
  const geometry::Vector6 error = geometry::log(predicted.inverse() * measured);
  return error.head<3>().norm() > kRotation || error.tail<3>().norm() > kTranslation;
}

}  // namespace

LidarMotion::LidarMotion(const Eigen::Isometry3d& T_vehicle_lidar)
    : lidar_odometry_(T_vehicle_lidar),
      measured_motion_({.capacity = 2, .max_gap = Duration(10'000'000'000)}),
      lidar_trajectory_(T_vehicle_lidar) {}

// The velocity is that of the time between the last two middles: both ends lag alike where it
// changes evenly. A first motion is that between the middles.
std::optional<motion::RelativePose> LidarMotion::follow(const Sweep& sweep, Stamp end) {
  if (!followed_) lidar_trajectory_.reset();
  const std::optional<End> last = followed_;
  lidar_odometry_.reset();
  located_ = map_deskewed_ = false;
  const registration::LidarOdometryResult& result = lidar_trajectory_.add(sweep);
  followed_ = End{end, std::nullopt};
  if (!result.usable()) return std::nullopt;
  followed_->T_map_vehicle = lidar_trajectory_.T_map_end();
  if (!last) return std::nullopt;
  motion::RelativePose motion = result.motion;
  motion.from = last->stamp;
  motion.to = end;
  if (last->T_map_vehicle) {
    motion.T_from_to = last->T_map_vehicle->inverse() * *followed_->T_map_vehicle;
  }
  return motion;
}

LidarMotion::Found LidarMotion::align(const Sweep& sweep, const OdometryTracker& odometry,
                                      motion::Deskewer& deskewer, motion::DeskewedSweep& deskewed) {
  const Stamp end = deskewed.reference;
  std::optional<Eigen::Isometry3d> guess;
  if (const auto motion = odometry.trajectory().between(last_registered_, end); motion.usable()) {
    guess = motion.T_from_to;
  }
  last_registered_ = end;
  if (deskewed.usable() && !map_deskewed_) lidar_odometry_.reset();
  Found found;
  found.first = lidar_odometry_.map_voxels() == 0;
  found.result = lidar_odometry_.align(points_of(deskewed), end, guess);
  found.wrong = (found.result.usable() || found.result.unsettled) && guess &&
                is_wrong(*guess, found.result.motion.T_from_to);
  if (found.wrong) {
    const motion::RelativePose step = found.result.motion;
    const geometry::Vector6 velocity =
        geometry::log(step.T_from_to) / to_seconds(step.to - step.from);
    motion::set_constant_motion(sweep, end, velocity, measured_motion_);
    deskewer.deskew(sweep, measured_motion_, end, deskewed);
    found.result = lidar_odometry_.align(points_of(deskewed), end, step.T_from_to);
  }
  found.measured = found.result.usable() && located_;
  return found;
}

void LidarMotion::take(const Found& found, bool predicted, const motion::DeskewedSweep& deskewed) {
  located_ = found.result.usable() || found.first;
  if (!predicted && !map_deskewed_ && deskewed.usable()) lidar_odometry_.reset();
  lidar_odometry_.add(points_of(deskewed), found.result);
  map_deskewed_ = deskewed.usable();
}

}  // namespace infuse::daemon
