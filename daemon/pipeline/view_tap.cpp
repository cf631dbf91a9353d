#include "daemon/pipeline/view_tap.hpp"

#include <algorithm>

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

/// Once for each value: afterwards no sweep makes it grow.
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

ViewTap::ViewTap(size_t cameras) : images_(cameras) {}

void ViewTap::add_sweep(const SweepSnapshot& snapshot, const Eigen::Isometry3d* T_odom_vehicle,
                        const ViewMapPose* map) {
  if (!wanted()) return;
  ViewSweep& sweep = sweep_.next();
  sweep.stamp = snapshot.deskewed.reference;
  sweep.lidar = snapshot.lidar;
  sweep.deskewed = snapshot.deskewed.usable();
  sweep.T_odom_vehicle.reset();
  if (T_odom_vehicle != nullptr) sweep.T_odom_vehicle = *T_odom_vehicle;
  sweep.map.reset();
  if (map != nullptr) sweep.map = *map;
  reserve(sweep.points);
  quantise(snapshot, kMaxPoints, sweep.points);
  sweep_.publish();
}

void ViewTap::add_image(const ImageMatch& match, const Eigen::Isometry3d* estimate) {
  if (!wanted() || match.image.camera >= images_.size()) return;
  Images& camera = images_[match.image.camera];
  ViewImage& image = camera.latest.next();
  image.camera = match.image.camera;
  image.frame = match.image.frame;
  image.T_camera_lidar = match.T_camera_lidar;
  image.T_camera_lidar_estimate.reset();
  if (estimate != nullptr) image.T_camera_lidar_estimate = *estimate;
  reserve(image.points);
  quantise(match.snapshot, kMaxPoints, image.points);
  if (camera.with_returns.load(std::memory_order_relaxed)) {
    copy_returns(match.snapshot, image.returns);
  } else {
    clear(image.returns);
  }
  camera.latest.publish();
}

bool ViewTap::swap_sweep(ViewSweep& out) { return sweep_.take(out); }

bool ViewTap::swap_image(CameraIndex camera, ViewImage& out, bool with_returns) {
  images_[camera].with_returns.store(with_returns, std::memory_order_relaxed);
  return images_[camera].latest.take(out);
}

}  // namespace infuse::daemon
