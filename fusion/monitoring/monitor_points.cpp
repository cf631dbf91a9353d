#include <algorithm>
#include <cmath>

#include "fusion/calibration/visible_points.hpp"
#include "fusion/features/ranks.hpp"
#include "fusion/monitoring/monitor_view.hpp"

namespace infuse::monitoring {
namespace {

constexpr float kMinDepth = static_cast<float>(calibration::VisibilityOptions{}.min_depth);  // m
constexpr float kMinRange = 2;  // m; nearer is the vehicle itself
constexpr float kMaxRange = static_cast<float>(calibration::kMaxSceneRange);  // m
constexpr float kBorderShare = 0.1F;                                          // of the image's size

}  // namespace

void ComparedReturns::thin(const ComparedReturns& others, size_t count) {
  count = std::min(count, others.size());
  const auto pick = [&](const auto& from, auto& to) {
    to.resize(count);
    for (size_t k = 0; k < count; ++k) to[k] = from[k * others.size() / count];
  };
  pick(others.x, x);
  pick(others.y, y);
  pick(others.z, z);
  pick(others.reflectivity_bin, reflectivity_bin);
  pick(others.edge_bin, edge_bin);
}

void MonitorPoints::find_visible(const SweepView& sweep, const geometry::CameraModel& camera,
                                 const Eigen::Isometry3d& T_camera_lidar) {
  for (auto* scratch : {&u_, &v_, &all_depth_}) scratch->resize(sweep.size());
  geometry::project_points(camera, T_camera_lidar, sweep.points, {u_, v_, all_depth_});
  const CameraIntrinsics& image = camera.intrinsics();
  const auto right = static_cast<float>(image.width - 1);
  const auto bottom = static_cast<float>(image.height - 1);
  occlusion_.reset(image.width, image.height);
  for (auto* chosen : {&visible_, &near_image_}) {
    chosen->clear();
    chosen->reserve(sweep.size());
  }
  for (size_t i = 0; i < sweep.size(); ++i) {
    // NaN where the camera's model does not see the point: no comparison holds.
    const bool near = u_[i] >= -kBorderShare * right && u_[i] <= (1 + kBorderShare) * right &&
                      v_[i] >= -kBorderShare * bottom && v_[i] <= (1 + kBorderShare) * bottom &&
                      all_depth_[i] >= kMinDepth && sweep.range[i] >= kMinRange &&
                      sweep.range[i] <= kMaxRange;
    if (!near) continue;
    near_image_.push_back(static_cast<uint32_t>(i));
    if (!(u_[i] >= 0 && u_[i] <= right && v_[i] >= 0 && v_[i] <= bottom)) continue;
    visible_.push_back(static_cast<uint32_t>(i));
    occlusion_.add(u_[i], v_[i], all_depth_[i]);
  }
  std::erase_if(visible_,
                [&](uint32_t i) { return occlusion_.hides(u_[i], v_[i], all_depth_[i]); });
}

/// Sorts the selected returns' values of a feature into bins of equal filling; equal values share
/// one.
void MonitorPoints::sort_into_bins(std::span<const float> feature, std::vector<uint8_t>& bins) {
  constexpr int kBins = ComparedReturns::kBins;
  const size_t count = size();
  values_.resize(count);
  bins.resize(count);
  float max_value = 1e-6F;
  for (size_t k = 0; k < count; ++k) {
    values_[k] = feature[visible_[k * visible_.size() / count]];
    if (values_[k] > max_value) max_value = values_[k];  // false for NaN
  }
  features::equalize_by_level(values_, max_value);
  for (size_t k = 0; k < count; ++k) {
    bins[k] = std::isnan(values_[k])
                  ? ComparedReturns::kNotCompared
                  : static_cast<uint8_t>(std::min(kBins - 1, static_cast<int>(values_[k] * kBins)));
  }
}

void MonitorPoints::select(const SweepView& sweep, const geometry::CameraModel& camera,
                           const Eigen::Isometry3d& T_camera_lidar, size_t max_points) {
  discontinuity_ = discontinuities_.compute(sweep);
  reflectivity_ = relative_reflectivity_.compute(sweep.ring, sweep.range, sweep.reflectivity);
  select_visible(sweep, camera, T_camera_lidar, max_points);
}

void MonitorPoints::select(const SweepView& sweep, const MonitorPoints& others,
                           const geometry::CameraModel& camera,
                           const Eigen::Isometry3d& T_camera_lidar, size_t max_points) {
  discontinuity_ = others.discontinuity_;
  reflectivity_ = others.reflectivity_;
  select_visible(sweep, camera, T_camera_lidar, max_points);
}

void MonitorPoints::select_visible(const SweepView& sweep, const geometry::CameraModel& camera,
                                   const Eigen::Isometry3d& T_camera_lidar, size_t max_points) {
  find_visible(sweep, camera, T_camera_lidar);
  const size_t count = std::min(visible_.size(), max_points);
  for (auto* quantity : {&compared_.x, &compared_.y, &compared_.z, &depth_}) {
    quantity->resize(count);
  }
  for (size_t k = 0; k < count; ++k) {
    const uint32_t i = visible_[k * visible_.size() / count];
    compared_.x[k] = sweep.points.x[i];
    compared_.y[k] = sweep.points.y[i];
    compared_.z[k] = sweep.points.z[i];
    depth_[k] = all_depth_[i];
  }
  sort_into_bins(reflectivity_, compared_.reflectivity_bin);
  sort_into_bins(discontinuity_, compared_.edge_bin);
}

}  // namespace infuse::monitoring
