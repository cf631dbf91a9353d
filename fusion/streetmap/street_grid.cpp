#include "fusion/streetmap/street_grid.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::streetmap {
namespace {

constexpr double kProfileStep = StreetGrid::kCell / 2;  // m

// Of a cell, as bits.
constexpr int kOnTop = 1, kBelow = 2, kJoined = 4;

uint8_t cell_of(const Segment& segment) {
  const bool crossing = segment.kind == SegmentKind::kCrossing;  // on a street of any level
  int what = segment.kind == SegmentKind::kCarriageway || crossing ? kOnTop : 0;
  if (segment.levels == StreetLevels::kBelow) what |= kBelow;
  if (segment.levels == StreetLevels::kJoined || crossing) what |= kJoined;
  return what == 0 ? uint8_t{0} : static_cast<uint8_t>((segment.layer + 16) << 3 | what);
}

int layer_of(uint8_t cell) { return (cell >> 3) - 16; }

/// True if a cell has a street of a level.
bool is_street(uint8_t cell, int level) {
  if (cell == 0) return false;
  if (level == StreetGrid::kAnyLevel || (cell & kJoined) != 0) return true;
  if ((cell & kOnTop) != 0 && level == layer_of(cell)) return true;
  return (cell & kBelow) != 0 && level < layer_of(cell);
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
  tile_columns_ = (static_cast<size_t>(columns_) + kEdge - 1) / kEdge;
  tile_at_.resize(tile_columns_ * ((static_cast<size_t>(rows_) + kEdge - 1) / kEdge));
  tiles_.resize(1);
  mixed_.resize(1);
  std::vector<uint8_t> cell_of_id(map.segment_count());
  for (uint32_t id = 0; id < map.segment_count(); ++id) {
    const Segment segment = map.segment(id);
    cell_of_id[id] = cell_of(segment);
    has_levels_ |= segment.layer != 0 || segment.levels != StreetLevels::kOne;
  }
  std::vector<uint32_t> ids(static_cast<size_t>(map.columns()));
  std::vector<Cells> band(tile_columns_);
  for (int row = 0; row < rows_; ++row) {
    map.read_row(0, static_cast<int>((row + 0.5) * kCell / frame.cell_size), ids);
    const size_t in_tile = static_cast<size_t>(row) % kEdge;
    if (in_tile == 0) std::fill(band.begin(), band.end(), Cells{});
    for (int column = 0; column < columns_; ++column) {
      const auto i = static_cast<size_t>((column + 0.5) * kCell / frame.cell_size);
      const auto at = static_cast<size_t>(column);
      if (i >= ids.size() || ids[i] >= cell_of_id.size()) continue;
      band[at / kEdge][in_tile * kEdge + at % kEdge] = cell_of_id[ids[i]];
    }
    if (in_tile + 1 < kEdge && row + 1 < rows_) continue;
    for (size_t k = 0; k < tile_columns_; ++k) {
      add_tile(static_cast<size_t>(row) / kEdge * tile_columns_ + k, band[k]);
    }
    if (mixed_.size() > kMaxMixed) {
      *this = StreetGrid();
      return;
    }
  }
}

void StreetGrid::add_tile(size_t index, const Cells& cells) {
  Tile tile;
  bool alike = true;
  for (size_t i = 0; i < cells.size(); ++i) {
    if (cells[i] == 0) continue;
    tile.streets |= uint64_t{1} << i;
    alike = alike && (tile.cell == 0 || tile.cell == cells[i]);
    tile.cell = cells[i];
  }
  if (tile.streets == 0) return;
  if (!alike) {
    tile.mixed = static_cast<uint32_t>(mixed_.size());
    mixed_.push_back(cells);
  }
  tile_at_[index] = static_cast<uint32_t>(tiles_.size());
  tiles_.push_back(tile);
}

Eigen::Vector2d StreetGrid::middle(int column, int row) const {
  return {low_x_ + (column + 0.5) * kCell, low_y_ + (row + 0.5) * kCell};
}

uint8_t StreetGrid::cell(double x, double y) const {
  const double column = (x - low_x_) / kCell, row = (y - low_y_) / kCell;
  if (!(column >= 0 && row >= 0 && column < columns_ && row < rows_)) return 0;
  const auto x_cell = static_cast<size_t>(column), y_cell = static_cast<size_t>(row);
  const Tile& tile = tiles_[tile_at_[y_cell / kEdge * tile_columns_ + x_cell / kEdge]];
  const size_t i = y_cell % kEdge * kEdge + x_cell % kEdge;
  if ((tile.streets >> i & 1) == 0) return 0;
  return tile.mixed == 0 ? tile.cell : mixed_[tile.mixed][i];
}

bool StreetGrid::street(double x, double y, int level) const {
  return is_street(cell(x, y), level);
}

bool StreetGrid::joined_between(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
  const int steps = static_cast<int>((to - from).norm() / kCell) + 1;
  for (int i = 0; i <= steps; ++i) {
    const Eigen::Vector2d p = from + (to - from) * i / steps;
    if ((cell(p.x(), p.y()) & kJoined) != 0) return true;
  }
  return false;
}

int StreetGrid::level_after(int level, const Eigen::Vector2d& from,
                            const Eigen::Vector2d& to) const {
  if (!has_levels_) return level;
  const uint8_t there = cell(to.x(), to.y());
  if (there == 0) return level;
  if ((there & kJoined) != 0) return kAnyLevel;
  if (!is_street(there, level) && joined_between(from, to)) level = kAnyLevel;
  if (level != kAnyLevel) return level;
  if ((there & kOnTop) == 0) return kBelowGround;
  return (there & kBelow) == 0 ? layer_of(there) : kAnyLevel;
}

double StreetGrid::free_length(const PlanarPose& pose, double reach) const {
  const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  double length = 0;
  while (length < reach && street(pose.x + c * length, pose.y + s * length)) length += kCell;
  return length;
}

std::optional<StreetProfile> StreetGrid::across(const PlanarPose& pose, int level) const {
  const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  const auto at = [&](double left) { return street(pose.x - s * left, pose.y + c * left, level); };
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
