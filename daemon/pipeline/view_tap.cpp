#include "daemon/pipeline/view_tap.hpp"

#include <algorithm>
#include <utility>

namespace infuse::daemon {
namespace {

int16_t centimetres(float metres) {
  constexpr float kLimit = 32'767;
  return static_cast<int16_t>(std::clamp(100 * metres, -kLimit, kLimit));
}

void copy_returns(const SweepSnapshot& snapshot, ViewReturns& out) {
  const Sweep& sweep = snapshot.sweep;
  const motion::DeskewedSweep& at = snapshot.deskewed;
  out.x.assign(at.x.begin(), at.x.end());
  out.y.assign(at.y.begin(), at.y.end());
  out.z.assign(at.z.begin(), at.z.end());
  out.range.assign(sweep.range.begin(), sweep.range.end());
  out.reflectivity.assign(sweep.reflectivity.begin(), sweep.reflectivity.end());
  out.ring.assign(sweep.ring.begin(), sweep.ring.end());
  out.column.assign(sweep.column.begin(), sweep.column.end());
}

void clear(ViewReturns& returns) {
  for (auto* values : {&returns.x, &returns.y, &returns.z, &returns.range, &returns.reflectivity}) {
    values->clear();
  }
  returns.ring.clear();
  returns.column.clear();
}

void reserve(ViewPoints& points) {
  points.x.reserve(ViewTap::kMaxPoints);
  points.y.reserve(ViewTap::kMaxPoints);
  points.z.reserve(ViewTap::kMaxPoints);
  points.reflectivity.reserve(ViewTap::kMaxPoints);
  points.ring.reserve(ViewTap::kMaxPoints);
}

}  // namespace

void quantise(const SweepSnapshot& snapshot, size_t max_points, ViewPoints& points) {
  const Sweep& sweep = snapshot.sweep;
  const motion::DeskewedSweep& at = snapshot.deskewed;
  const size_t step = std::max<size_t>(1, (sweep.size() + max_points - 1) / max_points);
  const size_t count = (sweep.size() + step - 1) / step;
  points.x.resize(count);
  points.y.resize(count);
  points.z.resize(count);
  points.reflectivity.resize(count);
  points.ring.resize(count);
  for (size_t i = 0, from = 0; i < count; ++i, from += step) {
    points.x[i] = centimetres(at.x[from]);
    points.y[i] = centimetres(at.y[from]);
    points.z[i] = centimetres(at.z[from]);
    points.reflectivity[i] =
        static_cast<uint8_t>(std::clamp(255 * sweep.reflectivity[from], 0.0F, 255.0F));
    points.ring[i] = static_cast<uint8_t>(std::min<uint16_t>(sweep.ring[from], 255));
  }
}

ViewTap::ViewTap(size_t cameras) : images_(cameras) {
  reserve(sweep_.value.points);
  for (Slot<ViewImage>& image : images_) reserve(image.value.points);
}

void ViewTap::add_sweep(const SweepSnapshot& snapshot, const Eigen::Isometry3d* T_odom_vehicle,
                        const ViewMapPose* map) {
  if (!wanted()) return;
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock) return;
  ViewSweep& sweep = sweep_.value;
  sweep.stamp = snapshot.deskewed.reference;
  sweep.lidar = snapshot.lidar;
  sweep.deskewed = snapshot.deskewed.usable();
  sweep.T_odom_vehicle.reset();
  if (T_odom_vehicle != nullptr) sweep.T_odom_vehicle = *T_odom_vehicle;
  sweep.map.reset();
  if (map != nullptr) sweep.map = *map;
  quantise(snapshot, kMaxPoints, sweep.points);
  sweep_.fresh = true;
}

void ViewTap::add_image(const ImageMatch& match, const Eigen::Isometry3d* estimate) {
  if (!wanted()) return;
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock || match.image.camera >= images_.size()) return;
  Slot<ViewImage>& slot = images_[match.image.camera];
  slot.value.camera = match.image.camera;
  slot.value.frame = match.image.frame;
  slot.value.T_camera_lidar = match.T_camera_lidar;
  slot.value.T_camera_lidar_estimate.reset();
  if (estimate != nullptr) slot.value.T_camera_lidar_estimate = *estimate;
  quantise(match.snapshot, kMaxPoints, slot.value.points);
  if (slot.with_returns) {
    copy_returns(match.snapshot, slot.value.returns);
  } else {
    clear(slot.value.returns);
  }
  slot.fresh = true;
}

bool ViewTap::swap_sweep(ViewSweep& out) {
  const std::lock_guard lock(mutex_);
  if (!std::exchange(sweep_.fresh, false)) return false;
  std::swap(sweep_.value, out);
  return true;
}

bool ViewTap::swap_image(CameraIndex camera, ViewImage& out, bool with_returns) {
  const std::lock_guard lock(mutex_);
  images_[camera].with_returns = with_returns;
  if (!std::exchange(images_[camera].fresh, false)) return false;
  std::swap(images_[camera].value, out);
  return true;
}

}  // namespace infuse::daemon
