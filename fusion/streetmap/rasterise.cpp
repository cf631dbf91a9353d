#include "fusion/streetmap/rasterise.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "fusion/streetmap/tile_painter.hpp"

namespace infuse::streetmap {
namespace {

struct Box {
  Eigen::Vector2d low{1e300, 1e300}, high{-1e300, -1e300};

  void add(const Eigen::Vector2d& point, double reach) {
    low = low.cwiseMin(point.array().matrix() - Eigen::Vector2d::Constant(reach));
    high = high.cwiseMax(point.array().matrix() + Eigen::Vector2d::Constant(reach));
  }
  bool empty() const { return low.x() > high.x(); }
};

double outer_half_width(const PlanStrip& strip) {
  return strip.half_width + strip.kerb_width + strip.sidewalk_width;
}

Box bounding_box(const PlanArea& area) {
  Box box;
  for (const Polyline& ring : area.rings) {
    for (const Eigen::Vector2d& point : ring) box.add(point, area.wall_width / 2);
  }
  return box;
}

/// Draws a plan tile by tile; an index lists the elements of each tile.
class Rasteriser {
 public:
  Rasteriser(const StreetPlan& plan, const RasterOptions& options)
      : plan_(plan), options_(options) {}

  Result<std::vector<std::byte>> run(std::string_view provenance) {
    if (auto placed = compute_frame(); !placed) return tl::unexpected(placed.error());
    assign_ids();
    index_elements();
    TilePainter painter(plan_, options_.cell_size);
    SegmentMapWriter writer(frame_, columns_, rows_);
    for (int row = 0; row < rows_; ++row) {
      for (int column = 0; column < columns_; ++column) {
        paint(painter, column, row);
        writer.add_tile(painter.ids());
      }
    }
    return writer.finish(segments_, provenance);
  }

 private:
  struct TileContent {
    std::vector<TilePainter::Piece> pieces;
    std::vector<uint32_t> areas;  // large ones first, buildings last
  };

  double edge() const { return options_.cell_size * SegmentMap::kTileSize; }

  Result<void> compute_frame() {
    Box box;
    for (const PlanStrip& strip : plan_.strips) {
      for (const Eigen::Vector2d& point : strip.points) box.add(point, outer_half_width(strip));
    }
    for (const PlanArea& area : plan_.areas) {
      const Box own = bounding_box(area);
      if (own.empty()) continue;
      box.add(own.low, 0);
      box.add(own.high, 0);
    }
    if (box.empty()) return fail("the map has no elements to draw");
    const Eigen::Vector2d size =
        box.high - box.low + Eigen::Vector2d::Constant(2 * options_.margin);
    if (!(size.maxCoeff() <= options_.max_extent) || !(size.x() * size.y() <= options_.max_area)) {
      return fail("the map spans " + std::to_string(std::lround(size.x() / 1000)) + " km × " +
                      std::to_string(std::lround(size.y() / 1000)) + " km, which is too large",
                  {}, "cut a smaller piece, for example with osmium extract");
    }
    // The corner is a whole number of cells from the origin, so that maps with one origin align.
    const Eigen::Vector2d low = box.low - Eigen::Vector2d::Constant(options_.margin);
    frame_.georeferenced = true;
    frame_.latitude = plan_.latitude;
    frame_.longitude = plan_.longitude;
    frame_.cell_size = options_.cell_size;
    frame_.min_corner = {std::floor(low.x() / options_.cell_size) * options_.cell_size,
                         std::floor(low.y() / options_.cell_size) * options_.cell_size};
    columns_ = static_cast<int>(std::ceil(size.x() / edge())) + 1;
    rows_ = static_cast<int>(std::ceil(size.y() / edge())) + 1;
    return {};
  }

  uint32_t new_id(SegmentKind kind, int64_t element) {
    segments_.push_back({kind, element});
    return static_cast<uint32_t>(segments_.size() - 1);
  }

  void assign_ids() {
    for (const PlanStrip& strip : plan_.strips) {
      ElementIds ids;
      const int64_t element = strip.segment.osm_id;
      ids.body = new_id(strip.segment.kind, element);
      if (strip.kerb_width > 0) ids.boundary = new_id(SegmentKind::kKerb, element);
      if (strip.sidewalk_width > 0) ids.sidewalk = new_id(SegmentKind::kSidewalk, element);
      strip_ids_.push_back(ids);
    }
    for (const PlanArea& area : plan_.areas) {
      ElementIds ids;
      ids.body = new_id(area.segment.kind, area.segment.osm_id);
      if (area.wall_width > 0) ids.boundary = new_id(SegmentKind::kWall, area.segment.osm_id);
      area_ids_.push_back(ids);
    }
  }

  template <class Visit>
  void for_each_tile(const Box& box, Visit visit) {
    const auto index = [&](double metres, int end) {
      return static_cast<int>(std::clamp(std::floor(metres / edge()), 0.0, end - 1.0));
    };
    const Eigen::Vector2d low = box.low - frame_.min_corner, high = box.high - frame_.min_corner;
    for (int row = index(low.y(), rows_); row <= index(high.y(), rows_); ++row) {
      for (int column = index(low.x(), columns_); column <= index(high.x(), columns_); ++column) {
        visit(tiles_[tile_index(column, row)]);
      }
    }
  }

  size_t tile_index(int column, int row) const {
    return static_cast<size_t>(row) * static_cast<size_t>(columns_) + static_cast<size_t>(column);
  }

  void index_elements() {
    tiles_.resize(static_cast<size_t>(columns_) * static_cast<size_t>(rows_));
    for (uint32_t s = 0; s < plan_.strips.size(); ++s) {
      const PlanStrip& strip = plan_.strips[s];
      for (uint32_t i = 0; i + 1 < strip.points.size(); ++i) {
        Box box;
        box.add(strip.points[i], outer_half_width(strip));
        box.add(strip.points[i + 1], outer_half_width(strip));
        for_each_tile(box, [&](TileContent& tile) { tile.pieces.push_back({s, i}); });
      }
    }
    std::vector<uint32_t> order(plan_.areas.size());
    std::iota(order.begin(), order.end(), 0U);
    const auto rank = [&](uint32_t a) {
      const PlanArea& area = plan_.areas[a];
      double size = 0;
      for (const Polyline& ring : area.rings) size += std::abs(signed_area(ring));
      return std::pair(area.segment.kind == SegmentKind::kBuilding, -size);
    };
    std::stable_sort(order.begin(), order.end(),
                     [&](uint32_t a, uint32_t b) { return rank(a) < rank(b); });
    for (const uint32_t a : order) {
      const Box box = bounding_box(plan_.areas[a]);
      if (box.empty()) continue;
      for_each_tile(box, [&](TileContent& tile) { tile.areas.push_back(a); });
    }
  }

  void paint(TilePainter& painter, int column, int row) {
    const TileContent& tile = tiles_[tile_index(column, row)];
    painter.begin_tile(frame_.min_corner + edge() * Eigen::Vector2d(column, row));
    for (const uint32_t a : tile.areas) painter.fill_area(plan_.areas[a], area_ids_[a].body);
    painter.draw_strips(tile.pieces, strip_ids_);
    for (const uint32_t a : tile.areas) {
      if (area_ids_[a].boundary != 0) painter.draw_wall(plan_.areas[a], area_ids_[a].boundary);
    }
  }

  const StreetPlan& plan_;
  RasterOptions options_;
  MapFrame frame_;
  int columns_ = 0, rows_ = 0;
  std::vector<Segment> segments_{Segment{}};
  std::vector<ElementIds> strip_ids_, area_ids_;
  std::vector<TileContent> tiles_;
};

}  // namespace

std::optional<std::string> RasterOptions::invalid() const {
  if (!(cell_size >= 0.05 && cell_size <= 2))
    return "cell_size of a street map must be within 0.05 … 2 m";
  if (!(margin >= 0 && margin <= 1000)) return "margin of a street map must be within 0 … 1000 m";
  if (!(max_extent > 0) || !(max_area > 0))
    return "max_extent and max_area of a street map must be positive";
  return std::nullopt;
}

Result<std::vector<std::byte>> rasterise(const StreetPlan& plan, const RasterOptions& options,
                                         std::string_view provenance) {
  if (const auto wrong = options.invalid()) return fail(*wrong);
  return Rasteriser(plan, options).run(provenance);
}

}  // namespace infuse::streetmap
