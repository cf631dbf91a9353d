#include <algorithm>
#include <cmath>
#include <limits>

#include "fusion/calibration/lidar_features.hpp"
#include "fusion/monitoring/monitor_view.hpp"

namespace infuse::monitoring {
namespace {

constexpr float kMinRange = 2;           // m; nearer is the vehicle itself
constexpr float kMaxRange = 100;         // m
constexpr float kBorderShare = 0.1F;     // of the picture's size
constexpr float kCellSize = 8;           // px, of the z-buffer
constexpr float kOcclusionRatio = 1.1F;  // a point so much farther than its cell's nearest
constexpr float kOcclusionStep = 0.3F;   // m, is hidden
constexpr uint32_t kNoIndex = std::numeric_limits<uint32_t>::max();
constexpr int kMaxColumnGap = 4;  // columns between neighbours on a ring
constexpr size_t kLevels = 1024;
constexpr calibration::DiscontinuityOptions kEdgeOptions;

}  // namespace

SweepView make_sweep_view(const Sweep& sweep) {
  return {{sweep.x, sweep.y, sweep.z}, sweep.range, sweep.reflectivity, sweep.ring, sweep.column};
}

/// I(3.6) with γ = ½: how much farther the neighbours on the ring are.
void MonitorPoints::find_discontinuity(const SweepView& sweep) {
  discontinuity_.assign(sweep.size(), 0.0F);
  std::fill(last_of_ring_.begin(), last_of_ring_.end(), kNoIndex);
  for (size_t i = 0; i < sweep.size(); ++i) {
    const size_t ring = sweep.ring[i];
    if (ring >= last_of_ring_.size()) last_of_ring_.resize(ring + 1, kNoIndex);
    const uint32_t before = last_of_ring_[ring];
    last_of_ring_[ring] = static_cast<uint32_t>(i);
    if (before == kNoIndex || sweep.column[i] > sweep.column[before] + kMaxColumnGap) continue;
    const float step = sweep.range[i] - sweep.range[before];
    discontinuity_[before] = std::max(discontinuity_[before], step);
    discontinuity_[i] = std::max(discontinuity_[i], -step);
  }
  mask_far_from_edges(sweep);
  for (float& step : discontinuity_) step = std::sqrt(step);
}

/// NaN for returns farther along their ring from any edge than
/// `calibration::DiscontinuityOptions::reach`.
void MonitorPoints::mask_far_from_edges(const SweepView& sweep) {
  near_edge_.assign(sweep.size(), 0);
  const auto mark = [&](size_t i) {
    uint32_t& edge = last_of_ring_[sweep.ring[i]];
    if (discontinuity_[i] >= kEdgeOptions.min_edge_step) edge = static_cast<uint32_t>(i);
    if (edge == kNoIndex) return;
    const float ax = sweep.points.x[i], ay = sweep.points.y[i];
    const float bx = sweep.points.x[edge], by = sweep.points.y[edge];
    const float dot = ax * bx + ay * by;
    if (dot > 0 &&
        std::abs(ax * by - ay * bx) <= static_cast<float>(kEdgeOptions.max_edge_azimuth) * dot)
      near_edge_[i] = 1;
  };
  std::fill(last_of_ring_.begin(), last_of_ring_.end(), kNoIndex);
  for (size_t i = 0; i < sweep.size(); ++i) mark(i);
  std::fill(last_of_ring_.begin(), last_of_ring_.end(), kNoIndex);
  for (size_t i = sweep.size(); i-- > 0;) mark(i);
  for (size_t i = 0; i < sweep.size(); ++i) {
    if (near_edge_[i] == 0) discontinuity_[i] = calibration::kNotCompared;
  }
}

void MonitorPoints::find_visible(const SweepView& sweep, const geometry::CameraModel& camera,
                                 const Eigen::Isometry3d& T_camera_lidar) {
  for (auto* scratch : {&u_, &v_, &all_depth_}) scratch->resize(sweep.size());
  geometry::project_points(camera, T_camera_lidar, sweep.points, {u_, v_, all_depth_});
  const CameraIntrinsics& image = camera.intrinsics();
  const auto columns = static_cast<size_t>(static_cast<float>(image.width) / kCellSize) + 1;
  const auto rows = static_cast<size_t>(static_cast<float>(image.height) / kCellSize) + 1;
  nearest_.assign(columns * rows, std::numeric_limits<float>::infinity());
  const auto right = static_cast<float>(image.width - 1);
  const auto bottom = static_cast<float>(image.height - 1);
  const auto cell = [&](size_t i) {
    return static_cast<size_t>(v_[i] / kCellSize) * columns +
           static_cast<size_t>(u_[i] / kCellSize);
  };
  for (auto* chosen : {&visible_, &near_image_}) {
    chosen->clear();
    chosen->reserve(sweep.size());
  }
  for (size_t i = 0; i < sweep.size(); ++i) {
    // NaN where the camera's model does not see the point: no comparison holds.
    const bool near = u_[i] >= -kBorderShare * right && u_[i] <= (1 + kBorderShare) * right &&
                      v_[i] >= -kBorderShare * bottom && v_[i] <= (1 + kBorderShare) * bottom &&
                      all_depth_[i] >= 1 && sweep.range[i] >= kMinRange &&
                      sweep.range[i] <= kMaxRange;
    if (!near) continue;
    near_image_.push_back(static_cast<uint32_t>(i));
    if (!(u_[i] >= 0 && u_[i] <= right && v_[i] >= 0 && v_[i] <= bottom)) continue;
    visible_.push_back(static_cast<uint32_t>(i));
    float& nearest = nearest_[cell(i)];
    nearest = std::min(nearest, all_depth_[i]);
  }
  std::erase_if(visible_, [&](uint32_t i) {
    return all_depth_[i] > nearest_[cell(i)] * kOcclusionRatio + kOcclusionStep;
  });
}

/// Bins of equal filling; equal values share one, NaN is not compared.
void MonitorPoints::sort_into_bins(const std::vector<float>& values, std::vector<uint8_t>& bins) {
  bins.resize(values.size());
  float max_value = 1e-6F;
  size_t compared = 0;
  for (const float value : values) {
    if (std::isnan(value)) continue;
    max_value = std::max(max_value, value);
    ++compared;
  }
  const auto level = [&](float value) {
    return std::min(static_cast<size_t>(value / max_value * kLevels), kLevels - 1);
  };
  std::array<uint32_t, kLevels> count{};
  for (const float value : values) {
    if (!std::isnan(value)) ++count[level(value)];
  }
  std::array<uint8_t, kLevels> bin{};
  double below = 0;
  for (size_t i = 0; i < kLevels; ++i) {
    const double rank =
        (below + 0.5 * count[i]) / static_cast<double>(std::max<size_t>(compared, 1));
    bin[i] = static_cast<uint8_t>(std::min(kBins - 1, static_cast<int>(rank * kBins)));
    below += count[i];
  }
  for (size_t i = 0; i < values.size(); ++i) {
    bins[i] = std::isnan(values[i]) ? kNotCompared : bin[level(values[i])];
  }
}

void MonitorPoints::select(const SweepView& sweep, const geometry::CameraModel& camera,
                           const Eigen::Isometry3d& T_camera_lidar, size_t max_value) {
  find_discontinuity(sweep);
  relative_ = ranks_.compute(sweep.ring, sweep.range, sweep.reflectivity);
  find_visible(sweep, camera, T_camera_lidar);
  const size_t count = std::min(visible_.size(), max_value);
  for (auto* quantity : {&x_, &y_, &z_, &depth_, &values_}) quantity->resize(count);
  for (size_t k = 0; k < count; ++k) {
    const uint32_t i = visible_[k * visible_.size() / count];
    x_[k] = sweep.points.x[i];
    y_[k] = sweep.points.y[i];
    z_[k] = sweep.points.z[i];
    depth_[k] = all_depth_[i];
    values_[k] = relative_[i];
  }
  sort_into_bins(values_, reflectivity_bin_);
  for (size_t k = 0; k < count; ++k) {
    values_[k] = discontinuity_[visible_[k * visible_.size() / count]];
  }
  sort_into_bins(values_, edge_bin_);
}

}  // namespace infuse::monitoring
