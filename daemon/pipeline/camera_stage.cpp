#include "daemon/pipeline/camera_stage.hpp"

#include "fusion/geometry/project_points.hpp"

namespace infuse::daemon {
namespace {

constexpr Duration kFarOff{200'000'000};  // a picture and a sweep do not belong together

/// How bright a picture is, by every eighth pixel of every eighth row.
void measure_exposure(const CameraFrame& frame, FrameReport& report) {
  constexpr size_t kStep = 8;
  constexpr uint8_t kDark = 8, kBright = 247;
  const size_t pixel = static_cast<size_t>(channels(frame.format));
  const size_t middle = pixel == 3 ? 1 : 0;  // green stands for luminance
  uint64_t sum = 0, count = 0, dark = 0, bright = 0;
  for (size_t row = 0; row < static_cast<size_t>(frame.height); row += kStep) {
    const uint8_t* values = frame.pixels.data() + row * frame.row_bytes();
    for (size_t at = middle; at < frame.row_bytes(); at += kStep * pixel) {
      sum += values[at];
      dark += values[at] <= kDark ? 1 : 0;
      bright += values[at] >= kBright ? 1 : 0;
      ++count;
    }
  }
  const double all = static_cast<double>(std::max<uint64_t>(count, 1));
  report.mean_brightness = static_cast<double>(sum) / all / 255;
  report.dark = static_cast<double>(dark) / all;
  report.bright = static_cast<double>(bright) / all;
}

}  // namespace

CameraStage::CameraStage(const CameraMount& mount, const Eigen::Isometry3d& T_vehicle_lidar)
    : mount_(mount), model_(mount.intrinsics), compensator_(T_vehicle_lidar) {}

FrameReport CameraStage::look(const Picture& picture, const Sweep& sweep,
                              const geometry::Trajectory& trajectory) {
  FrameReport report;
  report.camera = picture.camera;
  report.stamp = picture.stamp;
  report.sequence = picture.frame.sequence;
  report.width = picture.frame.width;
  report.height = picture.frame.height;
  measure_exposure(picture.frame, report);
  report.sweep = sweep.sequence;
  report.sweep_offset = picture.stamp - sweep.stamp;
  if (picture.frame.width != mount_.intrinsics.width ||
      picture.frame.height != mount_.intrinsics.height) {
    report.reason = "the picture's size is not the one that the intrinsics are for";
    return report;
  }
  if (distance_between(picture.stamp, sweep.stamp) > sweep.span + kFarOff) {
    report.reason = "no sweep was taken near this picture";
    return report;
  }
  compensator_.compensate(sweep, trajectory, picture.stamp, straight_);
  report.straight_reason = straight_.reason;
  report.points_in_view = count_in_view();
  return report;
}

uint32_t CameraStage::count_in_view() {
  const size_t size = straight_.x.size();
  u_.resize(size);
  v_.resize(size);
  depth_.resize(size);
  geometry::project_points(model_, mount_.T_camera_lidar, {straight_.x, straight_.y, straight_.z},
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
