#include "fusion/streetmap/street_grid.hpp"

#include <cmath>

namespace infuse::streetmap {
namespace {

constexpr double kProfileStep = 0.5;  // m

bool is_street(SegmentKind kind) {
  return kind == SegmentKind::kCarriageway || kind == SegmentKind::kCrossing;
}

}  // namespace

StreetGrid::StreetGrid(const SegmentMap& map) {
  const MapFrame& frame = map.frame();
  const double width = map.columns() * frame.cell_size, height = map.rows() * frame.cell_size;
  if (map.empty() || width * height > kMaxArea) return;
  low_x_ = frame.min_corner.x();
  low_y_ = frame.min_corner.y();
  columns_ = static_cast<int>(std::ceil(width / kCell));
  rows_ = static_cast<int>(std::ceil(height / kCell));
  street_.resize(static_cast<size_t>(columns_) * static_cast<size_t>(rows_));
  std::vector<bool> is_street_id(map.segment_count());
  for (uint32_t id = 0; id < map.segment_count(); ++id) {
    is_street_id[id] = is_street(map.segment(id).kind);
  }
  std::vector<uint32_t> ids(static_cast<size_t>(map.columns()));
  for (int row = 0; row < rows_; ++row) {
    map.read_row(0, static_cast<int>((row + 0.5) * kCell / frame.cell_size), ids);
    uint8_t* cells = &street_[static_cast<size_t>(row) * static_cast<size_t>(columns_)];
    for (int column = 0; column < columns_; ++column) {
      const auto i = static_cast<size_t>((column + 0.5) * kCell / frame.cell_size);
      cells[column] = i < ids.size() && ids[i] < is_street_id.size() && is_street_id[ids[i]];
    }
  }
}

Eigen::Vector2d StreetGrid::middle(int column, int row) const {
  return {low_x_ + (column + 0.5) * kCell, low_y_ + (row + 0.5) * kCell};
}

bool StreetGrid::street(double x, double y) const {
  const double column = (x - low_x_) / kCell, row = (y - low_y_) / kCell;
  if (!(column >= 0 && row >= 0 && column < columns_ && row < rows_)) return false;
  return street_[static_cast<size_t>(row) * static_cast<size_t>(columns_) +
                 static_cast<size_t>(column)] != 0;
}

double StreetGrid::free_length(const PlanarPose& pose, double reach) const {
  const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  double length = 0;
  while (length < reach && street(pose.x + c * length, pose.y + s * length)) length += kCell;
  return length;
}

std::optional<StreetProfile> StreetGrid::across(const PlanarPose& pose) const {
  const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  const auto at = [&](double left) { return street(pose.x - s * left, pose.y + c * left); };
  std::optional<double> found;
  for (double d = 0; d <= kProfileReach && !found; d += kProfileStep) {
    if (at(d))
      found = d;
    else if (at(-d))
      found = -d;
  }
  if (!found) return std::nullopt;
  StreetProfile profile{*found, *found};
  while (profile.left < kProfileReach && at(profile.left + kProfileStep)) {
    profile.left += kProfileStep;
  }
  while (profile.right > -kProfileReach && at(profile.right - kProfileStep)) {
    profile.right -= kProfileStep;
  }
  return profile;
}

}  // namespace infuse::streetmap
