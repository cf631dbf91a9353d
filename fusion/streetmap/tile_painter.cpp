#include "fusion/streetmap/tile_painter.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::streetmap {
namespace {

constexpr uint32_t kNoStrip = UINT32_MAX;

bool is_drawn_street(const PlanStrip& strip) {
  return strip.segment.kind == SegmentKind::kCarriageway && !strip.tunnel;
}

/// Returns the cells [first, end) whose centres lie in [from, to] metres from the edge of the tile.
std::pair<int, int> cells_between(double from, double to, double cell) {
  const double last = TilePainter::kTileSize;
  const double first = std::clamp(std::ceil(from / cell - 0.5), 0.0, last);
  const double end = std::clamp(std::floor(to / cell - 0.5) + 1, 0.0, last);
  return {static_cast<int>(first), std::max(static_cast<int>(first), static_cast<int>(end))};
}

}  // namespace

void TilePainter::begin_tile(const Eigen::Vector2d& low) {
  min_corner_ = low;
  ids_.fill(0);
  on_carriageway_.fill(false);
  on_street_.fill(false);
  levels_.fill(StreetLevels::kOne);
}

void TilePainter::fill_area(std::span<const Edge> edges, uint32_t id) {
  const double south = min_corner_.y();
  for (int row = 0; row < kTileSize; ++row) {
    const double y = south + (row + 0.5) * cell_size_;
    crossings_.clear();
    for (const auto& [a, b] : edges) {
      if ((a.y() > y) == (b.y() > y)) continue;
      crossings_.push_back(a.x() + (y - a.y()) / (b.y() - a.y()) * (b.x() - a.x()) -
                           min_corner_.x());
    }
    std::sort(crossings_.begin(), crossings_.end());
    for (size_t i = 0; i + 1 < crossings_.size(); i += 2) {
      const auto [first, end] = cells_between(crossings_[i], crossings_[i + 1], cell_size_);
      for (int c = first; c < end; ++c) ids_[static_cast<size_t>(row * kTileSize + c)] = id;
    }
  }
}

// Calls visit(cell, distance, offset, beyond) for cells with centres within `reach` of the line
// from a to b. The offset is positive on the left of the line; beyond: -1 before a, 1 behind b,
// else 0.
template <class Visit>
void TilePainter::visit_near_line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double reach,
                                  Visit visit) {
  const Eigen::Vector2d from = a - min_corner_, along = b - a;
  const double length2 = std::max(along.squaredNorm(), 1e-12);
  const auto [row_begin, row_end] =
      cells_between(std::min(a.y(), b.y()) - min_corner_.y() - reach,
                    std::max(a.y(), b.y()) - min_corner_.y() + reach, cell_size_);
  const auto [first, end] =
      cells_between(std::min(a.x(), b.x()) - min_corner_.x() - reach,
                    std::max(a.x(), b.x()) - min_corner_.x() + reach, cell_size_);
  for (int row = row_begin; row < row_end; ++row) {
    for (int c = first; c < end; ++c) {
      const Eigen::Vector2d p = Eigen::Vector2d(c + 0.5, row + 0.5) * cell_size_ - from;
      const double place = p.dot(along) / length2, t = std::clamp(place, 0.0, 1.0);
      const double distance = (p - t * along).norm();
      if (distance >= reach) continue;
      const double offset = (along.x() * p.y() - along.y() * p.x()) / std::sqrt(length2);
      const int beyond = place < 0 ? -1 : place > 1 ? 1 : 0;
      visit(static_cast<size_t>(row * kTileSize + c), distance, offset, beyond);
    }
  }
}

// The nearest coastline decides. Where two meet, it is the one that the cell is farther beside.
void TilePainter::fill_coast(std::span<const Piece> pieces, std::span<const ElementIds> ids) {
  edge_distance_.fill(1e9F);
  nearest_strip_.fill(kNoStrip);
  for (const Piece& piece : pieces) {
    const PlanStrip& strip = plan_.strips[piece.strip];
    if (strip.segment.kind != SegmentKind::kWater) continue;
    visit_near_line(strip.points[piece.point], strip.points[piece.point + 1], strip.half_width,
                    [&](size_t cell, double distance, double offset, int) {
                      const auto key = static_cast<float>(distance - 1e-3 * std::abs(offset));
                      if (key >= edge_distance_[cell]) return;
                      edge_distance_[cell] = key;
                      nearest_strip_[cell] = offset < 0 ? piece.strip : kNoStrip;
                    });
  }
  for (size_t cell = 0; cell < kCellsPerTile; ++cell) {
    if (nearest_strip_[cell] != kNoStrip) ids_[cell] = ids[nearest_strip_[cell]].body;
  }
}

void TilePainter::draw_footways(std::span<const Piece> pieces, std::span<const ElementIds> ids) {
  for (const Piece& piece : pieces) {
    const PlanStrip& strip = plan_.strips[piece.strip];
    if (strip.segment.kind != SegmentKind::kFootway) continue;
    visit_near_line(strip.points[piece.point], strip.points[piece.point + 1], strip.half_width,
                    [&](size_t cell, double, double, int) { ids_[cell] = ids[piece.strip].body; });
  }
}

// Pavements, footways (on the lowest layer), kerbs and carriageways of one layer.
void TilePainter::draw_carriageways(std::span<const Piece> pieces, std::span<const ElementIds> ids,
                                    int layer) {
  edge_distance_.fill(1e9F);
  nearest_strip_.fill(kNoStrip);
  on_layer_.fill(false);
  for (const Piece& piece : pieces) {
    const PlanStrip& strip = plan_.strips[piece.strip];
    if (!is_drawn_street(strip) || strip.layer != layer) continue;
    const double reach = strip.half_width + strip.kerb_width +
                         std::max(strip.left_sidewalk_width, strip.right_sidewalk_width);
    const bool is_first = piece.point == 0, is_last = piece.point + 2 == strip.points.size();
    visit_near_line(strip.points[piece.point], strip.points[piece.point + 1], reach,
                    [&](size_t cell, double distance, double offset, int beyond) {
                      // A bridge ends where the street goes on at another layer.
                      const bool is_beyond = (is_first && beyond < 0) || (is_last && beyond > 0);
                      if (layer != 0 && is_beyond) return;
                      const auto edge = static_cast<float>(distance - strip.half_width);
                      if (edge < 0 && !is_beyond) on_layer_[cell] = true;
                      if (edge >= edge_distance_[cell]) return;
                      edge_distance_[cell] = edge;
                      nearest_strip_[cell] = piece.strip;
                      on_left_[cell] = offset > 0;
                    });
  }
  for (size_t cell = 0; cell < kCellsPerTile; ++cell) {
    if (nearest_strip_[cell] == kNoStrip || edge_distance_[cell] < 0) continue;
    const PlanStrip& strip = plan_.strips[nearest_strip_[cell]];
    const double width = on_left_[cell] ? strip.left_sidewalk_width : strip.right_sidewalk_width;
    if (edge_distance_[cell] < strip.kerb_width + width && width > 0) {
      ids_[cell] = ids[nearest_strip_[cell]].sidewalk;
      if (on_street_[cell]) levels_[cell] = StreetLevels::kBelow;
    }
  }
  if (layer == layers_.front()) draw_footways(pieces, ids);
  for (size_t cell = 0; cell < kCellsPerTile; ++cell) {
    if (nearest_strip_[cell] == kNoStrip) continue;
    const PlanStrip& strip = plan_.strips[nearest_strip_[cell]];
    if (edge_distance_[cell] >= strip.kerb_width) continue;
    on_carriageway_[cell] = edge_distance_[cell] < 0;
    const ElementIds& own = ids[nearest_strip_[cell]];
    ids_[cell] = on_carriageway_[cell] ? own.body : own.boundary;
    if (on_street_[cell]) levels_[cell] = StreetLevels::kBelow;
  }
  for (size_t cell = 0; cell < kCellsPerTile; ++cell) on_street_[cell] |= on_layer_[cell];
}

void TilePainter::mark_tunnels(std::span<const Piece> pieces) {
  for (const Piece& piece : pieces) {
    const PlanStrip& strip = plan_.strips[piece.strip];
    if (!strip.tunnel) continue;
    visit_near_line(
        strip.points[piece.point], strip.points[piece.point + 1], strip.half_width,
        [&](size_t cell, double, double, int) { levels_[cell] = StreetLevels::kBelow; });
  }
}

void TilePainter::join_levels(const Eigen::Vector2d& middle, double radius) {
  visit_near_line(middle, middle, radius, [&](size_t cell, double, double, int) {
    if (on_carriageway_[cell] || levels_[cell] != StreetLevels::kOne) {
      levels_[cell] = StreetLevels::kJoined;
    }
  });
}

void TilePainter::draw_strips(std::span<const Piece> pieces, std::span<const ElementIds> ids) {
  layers_.clear();
  for (const Piece& piece : pieces) {
    const PlanStrip& strip = plan_.strips[piece.strip];
    if (is_drawn_street(strip)) layers_.push_back(strip.layer);
  }
  if (layers_.empty()) layers_.push_back(0);
  std::sort(layers_.begin(), layers_.end());
  layers_.erase(std::unique(layers_.begin(), layers_.end()), layers_.end());
  for (const int layer : layers_) draw_carriageways(pieces, ids, layer);
  mark_tunnels(pieces);
  for (const Piece& piece : pieces) {
    const PlanStrip& strip = plan_.strips[piece.strip];
    if (strip.segment.kind != SegmentKind::kCrossing) continue;
    visit_near_line(strip.points[piece.point], strip.points[piece.point + 1], strip.half_width,
                    [&](size_t cell, double, double, int) {
                      if (on_carriageway_[cell]) ids_[cell] = ids[piece.strip].body;
                    });
  }
}

void TilePainter::draw_wall(const PlanArea& area, uint32_t id) {
  for (const Polyline& ring : area.rings) {
    for (size_t i = 0; i < ring.size(); ++i) {
      visit_near_line(ring[i], ring[(i + 1) % ring.size()], area.wall_width / 2,
                      [&](size_t cell, double, double, int) {
                        if (!on_carriageway_[cell]) ids_[cell] = id;
                      });
    }
  }
}

}  // namespace infuse::streetmap
