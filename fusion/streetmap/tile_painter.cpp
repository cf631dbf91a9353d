#include "fusion/streetmap/tile_painter.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::streetmap {
namespace {

constexpr uint32_t kNoStrip = UINT32_MAX;

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
}

void TilePainter::fill_area(const PlanArea& area, uint32_t id) {
  const double south = min_corner_.y(), north = min_corner_.y() + kTileSize * cell_size_;
  edges_.clear();
  for (const Polyline& ring : area.rings) {
    for (size_t i = 0; i < ring.size(); ++i) {
      const Eigen::Vector2d& a = ring[i];
      const Eigen::Vector2d& b = ring[i + 1 == ring.size() ? 0 : i + 1];
      if (std::max(a.y(), b.y()) >= south && std::min(a.y(), b.y()) <= north) {
        edges_.emplace_back(a, b);
      }
    }
  }
  for (int row = 0; row < kTileSize; ++row) {
    const double y = south + (row + 0.5) * cell_size_;
    crossings_.clear();
    for (const auto& [a, b] : edges_) {
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

// Calls visit(cell, distance) for cells with centres within `reach` of the line from a to b.
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
      const double t = std::clamp(p.dot(along) / length2, 0.0, 1.0);
      const double distance = (p - t * along).norm();
      if (distance < reach) visit(static_cast<size_t>(row * kTileSize + c), distance);
    }
  }
}

void TilePainter::draw_strips(std::span<const Piece> pieces, std::span<const ElementIds> ids) {
  const auto each = [&](SegmentKind kind, const auto& draw) {
    for (const Piece& piece : pieces) {
      const PlanStrip& strip = plan_.strips[piece.strip];
      if (strip.segment.kind != kind) continue;
      draw(piece.strip, strip, strip.points[piece.point], strip.points[piece.point + 1]);
    }
  };
  edge_distance_.fill(1e9F);
  nearest_strip_.fill(kNoStrip);
  each(SegmentKind::kCarriageway,
       [&](uint32_t index, const PlanStrip& strip, const auto& a, const auto& b) {
         const double reach = strip.half_width + strip.kerb_width + strip.sidewalk_width;
         visit_near_line(a, b, reach, [&](size_t cell, double distance) {
           const auto edge = static_cast<float>(distance - strip.half_width);
           if (edge >= edge_distance_[cell]) return;
           edge_distance_[cell] = edge;
           nearest_strip_[cell] = index;
         });
       });
  for (size_t cell = 0; cell < kCellsPerTile; ++cell) {
    if (nearest_strip_[cell] == kNoStrip || edge_distance_[cell] < 0) continue;
    if (ids[nearest_strip_[cell]].sidewalk != 0) ids_[cell] = ids[nearest_strip_[cell]].sidewalk;
  }
  each(SegmentKind::kFootway,
       [&](uint32_t index, const PlanStrip& strip, const auto& a, const auto& b) {
         visit_near_line(a, b, strip.half_width,
                         [&](size_t cell, double) { ids_[cell] = ids[index].body; });
       });
  for (size_t cell = 0; cell < kCellsPerTile; ++cell) {
    if (nearest_strip_[cell] == kNoStrip) continue;
    const PlanStrip& strip = plan_.strips[nearest_strip_[cell]];
    if (edge_distance_[cell] < 0) {
      ids_[cell] = ids[nearest_strip_[cell]].body;
      on_carriageway_[cell] = true;
    } else if (edge_distance_[cell] < strip.kerb_width) {
      ids_[cell] = ids[nearest_strip_[cell]].boundary;
    }
  }
  each(SegmentKind::kCrossing,
       [&](uint32_t index, const PlanStrip& strip, const auto& a, const auto& b) {
         visit_near_line(a, b, strip.half_width, [&](size_t cell, double) {
           if (on_carriageway_[cell]) ids_[cell] = ids[index].body;
         });
       });
}

void TilePainter::draw_wall(const PlanArea& area, uint32_t id) {
  for (const Polyline& ring : area.rings) {
    for (size_t i = 0; i < ring.size(); ++i) {
      visit_near_line(ring[i], ring[(i + 1) % ring.size()], area.wall_width / 2,
                      [&](size_t cell, double) {
                        if (!on_carriageway_[cell]) ids_[cell] = id;
                      });
    }
  }
}

}  // namespace infuse::streetmap
