#include "fusion/places/place_selection.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/measurement/angles.hpp"
#include "fusion/mapping/position_grid.hpp"
#include "fusion/places/place_matcher.hpp"

namespace infuse::places {
namespace {

double heading_of(const Eigen::Isometry3d& T) {
  return std::atan2(T.linear()(1, 0), T.linear()(0, 0));
}

/// Share of the sectors in which `older` sees something, in which `newer` does too; `yaw` is the
/// heading of `older` as seen from `newer`.
double share_seen(const PlaceDescriptor& older, const PlaceDescriptor& newer, double yaw) {
  const int shift =
      static_cast<int>(std::lround(wrap_angle(yaw) / (2 * std::numbers::pi) * kSectors));
  int sees = 0, both = 0;
  for (int sector = 0; sector < kSectors; ++sector) {
    if (older.heights.col(sector).maxCoeff() <= 0) continue;
    ++sees;
    if (newer.heights.col((sector + shift + kSectors) % kSectors).maxCoeff() > 0) ++both;
  }
  return sees == 0 ? 1 : static_cast<double>(both) / sees;
}

}  // namespace

std::optional<std::string> PlaceSelectionOptions::invalid() const {
  if (!(distance > 0)) return "distance must be positive";
  if (!(min_seen >= 0 && min_seen <= 1)) return "min_seen must be between 0 and 1";
  return std::nullopt;
}

std::vector<size_t> select_places(const std::vector<mapping::Keyframe>& keyframes,
                                  const std::vector<Eigen::Isometry3d>& T_map_vehicle,
                                  const std::vector<PlaceDescriptor>& places,
                                  const PlaceSelectionOptions& options) {
  std::vector<size_t> newest;
  for (size_t k = keyframes.size(); k-- > 0;) {
    if (keyframes[k].has_cloud) newest.push_back(k);
  }
  std::stable_sort(newest.begin(), newest.end(),
                   [&](size_t a, size_t b) { return keyframes[a].stamp > keyframes[b].stamp; });
  mapping::PositionGrid grid(options.distance);
  std::vector<size_t> kept;
  for (const size_t k : newest) {
    const Eigen::Vector3d& position = T_map_vehicle[k].translation();
    bool replaced = false;
    grid.for_each_near(position, options.distance, [&](size_t other) {
      const Eigen::Vector3d apart = T_map_vehicle[other].translation() - position;
      if (replaced || apart.head<2>().norm() >= options.distance ||
          std::abs(apart.z()) > kMaxLevel) {
        return;
      }
      const double yaw = heading_of(T_map_vehicle[k]) - heading_of(T_map_vehicle[other]);
      replaced = share_seen(places[k], places[other], yaw) >= options.min_seen;
    });
    if (replaced) continue;
    grid.add(k, position);
    kept.push_back(k);
  }
  std::sort(kept.begin(), kept.end());
  return kept;
}

}  // namespace infuse::places
