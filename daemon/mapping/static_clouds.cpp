#include "daemon/mapping/static_clouds.hpp"

#include <algorithm>

namespace infuse::daemon {
namespace {

constexpr double kMaxViewDistance = 25;  // m, between a keyframe and those that judge it
constexpr size_t kMaxViews = 16;         // the nearest of them
constexpr size_t kMaxKeptViews = 64;

/// The nearest other keyframes that have a cloud.
std::vector<size_t> keyframes_around(const MapContent& map, size_t k) {
  const std::vector<Eigen::Isometry3d>& T_map_vehicle = map.T_map_vehicle;
  std::vector<std::pair<double, size_t>> near;
  for (size_t other = 0; other < T_map_vehicle.size(); ++other) {
    const double distance =
        (T_map_vehicle[other].translation() - T_map_vehicle[k].translation()).norm();
    if (other != k && distance < kMaxViewDistance && map.drive.keyframes[other].keyframe.has_cloud)
      near.emplace_back(distance, other);
  }
  const size_t kept = std::min(kMaxViews, near.size());
  std::partial_sort(near.begin(), near.begin() + static_cast<ptrdiff_t>(kept), near.end());
  std::vector<size_t> out;
  for (size_t i = 0; i < kept; ++i) out.push_back(near[i].second);
  return out;
}

}  // namespace

StaticClouds::StaticClouds(const MapFolder& folder, const MapContent& map)
    : folder_(folder), map_(map) {
  static_assert(kMaxKeptViews > kMaxViews, "a keyframe's views must be consecutive");
}

Result<const mapping::SubmapView*> StaticClouds::view_of(size_t k) {
  const auto found = std::find_if(kept_.begin(), kept_.end(),
                                  [&](const Kept& kept) { return kept.keyframe == k; });
  if (found != kept_.end()) {
    kept_.splice(kept_.begin(), kept_, found);
    return kept_.front().view.get();
  }
  auto cloud = folder_.read_cloud(map_.drive.keyframes, k);
  if (!cloud) return tl::unexpected(cloud.error());
  kept_.push_front({k, std::make_unique<mapping::SubmapView>(std::move(*cloud))});
  if (kept_.size() > kMaxKeptViews) kept_.pop_back();
  return kept_.front().view.get();
}

Result<mapping::Submap> StaticClouds::read(size_t k) {
  const Eigen::Isometry3d& T_vehicle_lidar = map_.drive.T_vehicle_lidar;
  const auto own = view_of(k);
  if (!own) return tl::unexpected(own.error());
  std::vector<mapping::PlacedView> views;
  for (const size_t other : keyframes_around(map_, k)) {
    const auto view = view_of(other);
    if (!view) return tl::unexpected(view.error());
    const Eigen::Isometry3d T_vehicle_other =
        map_.T_map_vehicle[k].inverse() * map_.T_map_vehicle[other] * T_vehicle_lidar;
    views.push_back({*view, T_vehicle_other.inverse() * T_vehicle_lidar});
  }
  const mapping::Submap& cloud = (*own)->submap;
  mapping::Submap still =
      mapping::without_moving_points(cloud, mapping::find_moving_points(cloud, views));
  points_ += cloud.size();
  removed_ += cloud.size() - still.size();
  return still;
}

}  // namespace infuse::daemon
