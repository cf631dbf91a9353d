#include "daemon/pipeline/camera_channel.hpp"

#include "daemon/pipeline/pairing.hpp"
#include "drivers/camera/colour.hpp"
#include "fusion/geometry/mean_twist.hpp"
#include "fusion/geometry/project_points.hpp"
#include "fusion/geometry/rolling_shutter.hpp"

namespace infuse::daemon {
CameraChannel::CameraChannel(const CameraMount& mount, LidarIndex lidar,
                             const Eigen::Isometry3d& T_vehicle_lidar,
                             const CalibrationSettings& calibration, bool blocking)
    : mount_(mount),
      lidar_(lidar),
      T_vehicle_lidar_(T_vehicle_lidar),
      model_(mount.intrinsics),
      deskewer_(T_vehicle_lidar) {
  if (calibration.monitored) guard_.emplace(mount, calibration, blocking);
}

ImageMatch CameraChannel::project(const CameraImage& image, const Sweep& sweep,
                                  const geometry::Trajectory& trajectory) {
  ImageMatch match{image, {lidar_, sweep, deskewed_}, T_camera_lidar()};
  match.reason = mismatch(image, sweep);
  if (!match.usable()) return match;
  deskewer_.deskew(sweep, trajectory, image.stamp, deskewed_);
  move_to_rows(image.stamp, trajectory);
  match.points_in_view = count_points_in_view(deskewed_);
  return match;
}

const char* CameraChannel::mismatch(const CameraImage& image, const Sweep& sweep) const {
  if (image.frame.width != mount_.intrinsics.width ||
      image.frame.height != mount_.intrinsics.height) {
    return "image size differs from the intrinsics";
  }
  if (pairing_gap(image.stamp, sweep) > kMaxPairingGap) return "no sweep near the image";
  return "";
}

const CalibrationReport* CameraChannel::monitor(const ImageMatch& match,
                                                const geometry::Trajectory& trajectory) {
  if (!guard_) return nullptr;
  camera::to_grey(match.image.frame, grey_);
  const Sweep& sweep = match.snapshot.sweep;
  const motion::DeskewedSweep& deskewed = match.snapshot.deskewed;
  return guard_->process(grey_,
                         {{deskewed.x, deskewed.y, deskewed.z},
                          sweep.range,
                          sweep.reflectivity,
                          sweep.ring,
                          sweep.column},
                         motion_at(match.image.stamp, trajectory));
}

// Mean twist of the vehicle over the last 50 ms, in its own frame, as far as it is known.
std::optional<geometry::Vector6> CameraChannel::twist_before(
    Stamp exposure, const geometry::Trajectory& trajectory) {
  constexpr Duration kSpan{50'000'000};
  return geometry::mean_twist(trajectory, exposure - kSpan, exposure);
}

void CameraChannel::move_to_rows(Stamp exposure, const geometry::Trajectory& trajectory) {
  if (mount_.readout == Duration::zero() || !deskewed_.usable()) return;
  const auto twist = twist_before(exposure, trajectory);
  if (!twist) return;
  for (auto* pixels : {&u_, &v_, &depth_}) pixels->resize(deskewed_.x.size());
  geometry::RollingShutter{model_, mount_.readout,
                           geometry::adjoint(T_vehicle_lidar_.inverse()) * *twist}
      .move(T_camera_lidar(), deskewed_.x, deskewed_.y, deskewed_.z, {u_, v_, depth_});
}

// Motion of the camera at the exposure, in its own frame. Zero where it is not known: the image is
// then not evaluated.
monitoring::Motion CameraChannel::motion_at(Stamp exposure,
                                            const geometry::Trajectory& trajectory) const {
  const auto known = twist_before(exposure, trajectory);
  if (!known) return {};
  const geometry::Vector6& twist = *known;
  const Eigen::Isometry3d T_camera_vehicle = T_camera_lidar() * T_vehicle_lidar_.inverse();
  const Eigen::Vector3d camera = T_camera_vehicle.inverse().translation();
  return {T_camera_vehicle.linear() * twist.head<3>(),
          T_camera_vehicle.linear() * (twist.tail<3>() + twist.head<3>().cross(camera))};
}

uint32_t CameraChannel::count_points_in_view(const motion::DeskewedSweep& deskewed) {
  const size_t size = deskewed.x.size();
  u_.resize(size);
  v_.resize(size);
  depth_.resize(size);
  geometry::project_points(model_, T_camera_lidar(), {deskewed.x, deskewed.y, deskewed.z},
                           {u_, v_, depth_});
  const float right = static_cast<float>(mount_.intrinsics.width) - 0.5F;
  const float bottom = static_cast<float>(mount_.intrinsics.height) - 0.5F;
  uint32_t count = 0;
  for (size_t i = 0; i < size; ++i) {  // a NaN pixel is outside
    count += u_[i] >= -0.5F && u_[i] < right && v_[i] >= -0.5F && v_[i] < bottom ? 1U : 0U;
  }
  return count;
}

}  // namespace infuse::daemon
