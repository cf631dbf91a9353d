#include "daemon/pipeline/camera_channel.hpp"

#include "drivers/camera/colour.hpp"
#include "fusion/geometry/project_points.hpp"

namespace infuse::daemon {
namespace {

constexpr Duration kMaxSweepOffset{200'000'000};  // a picture and a sweep do not belong together

/// How bright a picture is, by every eighth pixel of every eighth row.
void measure_brightness(const CameraFrame& frame, FrameReport& report) {
  constexpr size_t kStep = 8;
  constexpr uint8_t kMaxDark = 8, kMinBright = 247;
  const size_t pixel = static_cast<size_t>(channels(frame.format));
  const size_t middle = pixel == 3 ? 1 : 0;  // green stands for luminance
  uint64_t sum = 0, count = 0, dark = 0, bright = 0;
  for (size_t row = 0; row < static_cast<size_t>(frame.height); row += kStep) {
    const uint8_t* values = frame.pixels.data() + row * frame.row_bytes();
    for (size_t at = middle; at < frame.row_bytes(); at += kStep * pixel) {
      sum += values[at];
      dark += values[at] <= kMaxDark ? 1 : 0;
      bright += values[at] >= kMinBright ? 1 : 0;
      ++count;
    }
  }
  const double all = static_cast<double>(std::max<uint64_t>(count, 1));
  report.mean_brightness = static_cast<double>(sum) / all / 255;
  report.dark = static_cast<double>(dark) / all;
  report.bright = static_cast<double>(bright) / all;
}

}  // namespace

CameraChannel::CameraChannel(const CameraMount& mount, const Eigen::Isometry3d& T_vehicle_lidar,
                             const CalibrationSettings& calibration, bool blocking)
    : mount_(mount),
      T_vehicle_lidar_(T_vehicle_lidar),
      model_(mount.intrinsics),
      deskewer_(T_vehicle_lidar) {
  if (calibration.monitored) guard_.emplace(mount, calibration, blocking);
}

FrameReport CameraChannel::project(const CameraImage& image, const Sweep& sweep,
                                   const geometry::Trajectory& trajectory) {
  projected_ = false;
  FrameReport report;
  report.camera = image.camera;
  report.stamp = image.stamp;
  report.sequence = image.frame.sequence;
  report.width = image.frame.width;
  report.height = image.frame.height;
  measure_brightness(image.frame, report);
  report.sweep = sweep.sequence;
  report.sweep_offset = image.stamp - sweep.stamp;
  if (image.frame.width != mount_.intrinsics.width ||
      image.frame.height != mount_.intrinsics.height) {
    report.reason = "the picture's size is not the one that the intrinsics are for";
    return report;
  }
  if (distance_between(image.stamp, sweep.stamp) > sweep.span + kMaxSweepOffset) {
    report.reason = "no sweep was taken near this picture";
    return report;
  }
  deskewer_.deskew(sweep, trajectory, image.stamp, deskewed_);
  report.deskew_reason = deskewed_.reason;
  report.points_in_view = count_points_in_view();
  projected_ = true;
  return report;
}

const CalibrationReport* CameraChannel::monitor(const CameraImage& image, const Sweep& sweep,
                                                const geometry::Trajectory& trajectory) {
  if (!guard_ || !projected_) return nullptr;
  camera::to_grey(image.frame, grey_);
  const monitoring::SweepView view{{deskewed_.x, deskewed_.y, deskewed_.z},
                                   sweep.range,
                                   sweep.reflectivity,
                                   sweep.ring,
                                   sweep.column};
  if (!guard_->process(grey_, view, motion_at(image.stamp, trajectory))) return nullptr;
  mount_.T_camera_lidar = guard_->T_camera_lidar();
  return &guard_->report();
}

// The camera's own motion while the picture was taken: the vehicle's twist over the last twentieth
// of a second, seen from the camera. Where it is not known the camera counts as standing, and
// nothing is looked at.
monitoring::Motion CameraChannel::motion_at(Stamp exposure,
                                            const geometry::Trajectory& trajectory) const {
  constexpr Duration kSpan{50'000'000};
  const geometry::MotionBetween moved = trajectory.between(exposure - kSpan, exposure);
  if (!moved.usable()) return {};
  const geometry::Vector6 twist = geometry::log(moved.T_from_to) / to_seconds(kSpan);
  const Eigen::Isometry3d T_camera_vehicle = mount_.T_camera_lidar * T_vehicle_lidar_.inverse();
  const Eigen::Vector3d camera = T_camera_vehicle.inverse().translation();
  return {T_camera_vehicle.linear() * twist.head<3>(),
          T_camera_vehicle.linear() * (twist.tail<3>() + twist.head<3>().cross(camera))};
}

uint32_t CameraChannel::count_points_in_view() {
  const size_t size = deskewed_.x.size();
  u_.resize(size);
  v_.resize(size);
  depth_.resize(size);
  geometry::project_points(model_, mount_.T_camera_lidar, {deskewed_.x, deskewed_.y, deskewed_.z},
                           {u_, v_, depth_});
  const float right = static_cast<float>(mount_.intrinsics.width) - 0.5F;
  const float bottom = static_cast<float>(mount_.intrinsics.height) - 0.5F;
  uint32_t count = 0;
  for (size_t i = 0; i < size; ++i) {  // a pixel that is NaN is not inside
    count += u_[i] >= -0.5F && u_[i] < right && v_[i] >= -0.5F && v_[i] < bottom ? 1U : 0U;
  }
  return count;
}

}  // namespace infuse::daemon
