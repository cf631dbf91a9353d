#include "fusion/streetmap/rasterise.hpp"

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>
#include <map>
#include <numeric>

#include "fusion/streetmap/tile_painter.hpp"

namespace infuse::streetmap {
namespace {

using Box = Eigen::AlignedBox2d;

constexpr double kJointReach = 3;  // m beside a street, of where two levels are joined

Box grow(const Box& box, double reach) {
  return {box.min() - Eigen::Vector2d::Constant(reach),
          box.max() + Eigen::Vector2d::Constant(reach)};
}

bool is_coast(const PlanStrip& strip) { return strip.segment.kind == SegmentKind::kWater; }

double outer_half_width(const PlanStrip& strip) {
  return strip.half_width + strip.kerb_width +
         std::max(strip.left_sidewalk_width, strip.right_sidewalk_width);
}

Box bounding_box(const Polyline& line) {
  Box box;
  for (const Eigen::Vector2d& point : line) box.extend(point);
  return box;
}

Box bounding_box(const PlanArea& area) {
  Box box;
  for (const Polyline& ring : area.rings) box.extend(bounding_box(ring));
  return box.isEmpty() ? box : grow(box, area.wall_width / 2);
}

/// Part of a line between two heights, m from west to east; nothing if the line does not reach
/// them.
std::optional<std::pair<double, double>> span_between(const Eigen::Vector2d& a,
                                                      const Eigen::Vector2d& b, double south,
                                                      double north) {
  if (std::max(a.y(), b.y()) < south || std::min(a.y(), b.y()) > north) return std::nullopt;
  if (a.y() == b.y()) return std::minmax(a.x(), b.x());
  const auto x_at = [&](double y) {
    return a.x() + std::clamp((y - a.y()) / (b.y() - a.y()), 0.0, 1.0) * (b.x() - a.x());
  };
  const double first = x_at(south), second = x_at(north);
  return std::pair(std::min(first, second), std::max(first, second));
}

/// Draws a plan by rows of tiles, those within the corridor of the streets only. Only one row's
/// elements are listed by tile at a time, so memory follows the plan and not its extent.
class Rasteriser {
 public:
  Rasteriser(const StreetPlan& plan, const RasterOptions& options)
      : plan_(plan), options_(options) {}

  Result<std::vector<std::byte>> run(std::string_view provenance,
                                     const std::function<void(double)>& progress) {
    if (auto placed = compute_frame(); !placed) return tl::unexpected(placed.error());
    if (auto marked = mark_corridor(); !marked) return tl::unexpected(marked.error());
    assign_ids();
    index_rows();
    TilePainter painter(plan_, options_.cell_size);
    SegmentMapWriter writer(frame_, columns_, rows_);
    for (int row = 0; row < rows_; ++row) {
      list_tiles(row);
      for (int column = 0; column < columns_; ++column) {
        if (!is_drawn_[tile_index(column, row)]) continue;
        paint(painter, column, row);
        writer.set_tile(column, row, separate_levels(painter));
      }
      if (progress) progress((row + 1.0) / rows_);
    }
    return writer.finish(segments_, provenance);
  }

 private:
  struct TileContent {
    std::vector<TilePainter::Piece> pieces;
    std::vector<uint32_t> areas;  // places in `row_areas_`: large ones first, buildings last
  };
  struct Joint {
    Eigen::Vector2d point;
    double reach = 0;
  };
  struct RowContent {
    std::vector<TilePainter::Piece> pieces;
    std::vector<uint32_t> areas;
    std::vector<Joint> joints;
  };
  struct RowArea {
    uint32_t area;
    std::vector<TilePainter::Edge> edges;  // those that reach the row
  };

  double edge() const { return options_.cell_size * SegmentMap::kTileSize; }

  Result<void> compute_frame() {
    Box streets, all;
    for (const PlanStrip& strip : plan_.strips) {
      if (is_coast(strip) || strip.points.empty()) continue;
      streets.extend(grow(bounding_box(strip.points), outer_half_width(strip)));
    }
    all = streets;
    for (const PlanArea& area : plan_.areas) all.extend(bounding_box(area));
    if (all.isEmpty()) return fail("the map has no elements to draw");
    Box box = grow(all, options_.margin);
    if (!streets.isEmpty()) box = box.intersection(grow(streets, options_.corridor));
    if (!plan_.limit.isEmpty()) box = box.intersection(plan_.limit);
    if (box.isEmpty()) return fail("the map has no elements within its limits");
    const Eigen::Vector2d size = box.sizes();
    if (!(size.maxCoeff() <= options_.max_extent)) {
      return fail("the map spans " + std::to_string(std::lround(size.x() / 1000)) + " km × " +
                      std::to_string(std::lround(size.y() / 1000)) + " km, which is too large",
                  {}, "cut a smaller piece with --clip");
    }
    // The corner is a whole number of cells from the origin, so that maps with one origin align.
    frame_.georeferenced = true;
    frame_.latitude = plan_.latitude;
    frame_.longitude = plan_.longitude;
    frame_.cell_size = options_.cell_size;
    frame_.min_corner = {std::floor(box.min().x() / options_.cell_size) * options_.cell_size,
                         std::floor(box.min().y() / options_.cell_size) * options_.cell_size};
    columns_ = static_cast<int>(std::ceil(size.x() / edge())) + 1;
    rows_ = static_cast<int>(std::ceil(size.y() / edge())) + 1;
    return {};
  }

  /// Marks the tiles that are drawn.
  Result<void> mark_corridor() {
    const size_t tiles = static_cast<size_t>(columns_) * static_cast<size_t>(rows_);
    is_drawn_.assign(tiles, false);
    bool streets = false;
    for (const PlanStrip& strip : plan_.strips) {
      if (is_coast(strip)) continue;
      streets = true;
      for (size_t i = 0; i + 1 < strip.points.size(); ++i) {
        for_each_tile_near(strip.points[i], strip.points[i + 1], options_.corridor,
                           [&](int column, int row) { is_drawn_[tile_index(column, row)] = true; });
      }
    }
    if (!streets) is_drawn_.assign(tiles, true);
    const auto drawn =
        static_cast<double>(std::count(is_drawn_.begin(), is_drawn_.end(), true)) * edge() * edge();
    if (drawn <= options_.max_area) return {};
    return fail("the surroundings of its streets cover " +
                    std::to_string(std::lround(drawn / 1e6)) + " km², more than the limit of " +
                    std::to_string(std::lround(options_.max_area / 1e6)) + " km²",
                {}, "cut a smaller piece with --clip, or choose larger cells");
  }

  uint32_t new_id(SegmentKind kind, int64_t element, int layer = 0) {
    segments_.push_back({kind, element, static_cast<int8_t>(std::clamp(layer, -16, 15))});
    return static_cast<uint32_t>(segments_.size() - 1);
  }

  /// Ids of a tile: an element is another segment where there are streets on other levels.
  std::span<const uint32_t, TilePainter::kCellsPerTile> separate_levels(
      const TilePainter& painter) {
    const auto ids = painter.ids();
    const auto levels = painter.levels();
    for (size_t cell = 0; cell < ids.size(); ++cell) {
      tile_ids_[cell] = ids[cell];
      if (levels[cell] == StreetLevels::kOne) continue;
      const auto [place, is_new] = level_ids_.try_emplace({ids[cell], levels[cell]}, 0U);
      if (is_new) {
        Segment segment = segments_[ids[cell]];
        segment.levels = levels[cell];
        segments_.push_back(segment);
        place->second = static_cast<uint32_t>(segments_.size() - 1);
      }
      tile_ids_[cell] = place->second;
    }
    return tile_ids_;
  }

  void assign_ids() {
    for (const PlanStrip& strip : plan_.strips) {
      ElementIds ids;
      const int64_t element = strip.segment.osm_id;
      ids.body = new_id(strip.segment.kind, element, strip.layer);
      if (strip.kerb_width > 0) ids.boundary = new_id(SegmentKind::kKerb, element, strip.layer);
      if (strip.left_sidewalk_width > 0 || strip.right_sidewalk_width > 0) {
        ids.sidewalk = new_id(SegmentKind::kSidewalk, element, strip.layer);
      }
      strip_ids_.push_back(ids);
    }
    for (const PlanArea& area : plan_.areas) {
      ElementIds ids;
      ids.body = new_id(area.segment.kind, area.segment.osm_id);
      if (area.wall_width > 0) ids.boundary = new_id(SegmentKind::kWall, area.segment.osm_id);
      area_ids_.push_back(ids);
    }
  }

  int tile_at(double metres, int end) const {
    return static_cast<int>(std::clamp(std::floor(metres / edge()), 0.0, end - 1.0));
  }
  int row_at(double y) const { return tile_at(y - frame_.min_corner.y(), rows_); }
  int column_at(double x) const { return tile_at(x - frame_.min_corner.x(), columns_); }
  double south_of(int row) const { return frame_.min_corner.y() + row * edge(); }
  Box raster() const {
    return {frame_.min_corner, frame_.min_corner + edge() * Eigen::Vector2d(columns_, rows_)};
  }

  /// Visits the tiles of a row within `reach` of a line, and some more.
  template <class Visit>
  void for_each_column_near(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double reach,
                            int row, Visit visit) const {
    const auto span = span_between(a, b, south_of(row) - reach, south_of(row) + edge() + reach);
    const Box map = raster();
    if (!span || span->second + reach < map.min().x() || span->first - reach > map.max().x()) {
      return;
    }
    const int last = column_at(span->second + reach);
    for (int column = column_at(span->first - reach); column <= last; ++column) visit(column);
  }

  template <class Visit>
  void for_each_tile_near(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double reach,
                          Visit visit) const {
    const auto [south, north] = std::minmax(a.y(), b.y());
    for (int row = row_at(south - reach); row <= row_at(north + reach); ++row) {
      for_each_column_near(a, b, reach, row, [&](int column) { visit(column, row); });
    }
  }

  size_t tile_index(int column, int row) const {
    return static_cast<size_t>(row) * static_cast<size_t>(columns_) + static_cast<size_t>(column);
  }

  /// Lists by row where streets of different levels share a point.
  void index_joints() {
    const auto level = [](const PlanStrip& s) { return s.tunnel ? INT_MIN : s.layer; };
    std::map<std::pair<double, double>, const PlanStrip*> raised;  // by point, not on the ground
    for (const bool on_ground : {false, true}) {
      for (const PlanStrip& strip : plan_.strips) {
        const bool is_street = strip.segment.kind == SegmentKind::kCarriageway;
        if (!is_street || (level(strip) == 0) != on_ground) continue;
        for (const Eigen::Vector2d& point : strip.points) {
          const std::pair key(point.x(), point.y());
          const auto known = on_ground ? raised.find(key) : raised.try_emplace(key, &strip).first;
          if (known == raised.end() || level(*known->second) == level(strip)) continue;
          const double width = std::max(known->second->half_width, strip.half_width);
          add_joint({point, width + kJointReach});
        }
      }
    }
  }

  void add_joint(const Joint& joint) {
    const double y = joint.point.y();
    if (!raster().contains(joint.point)) return;
    for (int row = row_at(y - joint.reach); row <= row_at(y + joint.reach); ++row) {
      row_contents_[static_cast<size_t>(row)].joints.push_back(joint);
    }
  }

  void index_rows() {
    row_contents_.resize(static_cast<size_t>(rows_));
    index_joints();
    const Box map = raster();
    for (uint32_t s = 0; s < plan_.strips.size(); ++s) {
      const PlanStrip& strip = plan_.strips[s];
      const double reach = outer_half_width(strip);
      for (uint32_t i = 0; i + 1 < strip.points.size(); ++i) {
        Box box(strip.points[i]);
        box = grow(box.extend(strip.points[i + 1]), reach);
        if (!map.intersects(box)) continue;
        for (int row = row_at(box.min().y()); row <= row_at(box.max().y()); ++row) {
          row_contents_[static_cast<size_t>(row)].pieces.push_back({s, i});
        }
      }
    }
    std::vector<uint32_t> order(plan_.areas.size());
    std::iota(order.begin(), order.end(), 0U);
    std::vector<std::pair<bool, double>> rank;
    for (const PlanArea& area : plan_.areas) {
      double size = 0;
      for (const Polyline& ring : area.rings) size += std::abs(signed_area(ring));
      rank.emplace_back(area.segment.kind == SegmentKind::kBuilding, -size);
      boxes_.push_back(bounding_box(area));
    }
    std::stable_sort(order.begin(), order.end(),
                     [&](uint32_t a, uint32_t b) { return rank[a] < rank[b]; });
    for (const uint32_t a : order) {
      if (boxes_[a].isEmpty() || !map.intersects(boxes_[a])) continue;
      for (int row = row_at(boxes_[a].min().y()); row <= row_at(boxes_[a].max().y()); ++row) {
        row_contents_[static_cast<size_t>(row)].areas.push_back(a);
      }
    }
  }

  /// Lists the elements of the tiles of a row.
  void list_tiles(int row) {
    tiles_.resize(static_cast<size_t>(columns_));
    for (TileContent& tile : tiles_) {
      tile.pieces.clear();
      tile.areas.clear();
    }
    row_areas_.clear();
    const RowContent& content = row_contents_[static_cast<size_t>(row)];
    for (const TilePainter::Piece& piece : content.pieces) {
      const PlanStrip& strip = plan_.strips[piece.strip];
      for_each_column_near(
          strip.points[piece.point], strip.points[piece.point + 1], outer_half_width(strip), row,
          [&](int column) { tiles_[static_cast<size_t>(column)].pieces.push_back(piece); });
    }
    for (const uint32_t a : content.areas) {
      const auto place = static_cast<uint32_t>(row_areas_.size());
      row_areas_.push_back({a, edges_within(plan_.areas[a], south_of(row))});
      const int last = column_at(boxes_[a].max().x());
      for (int column = column_at(boxes_[a].min().x()); column <= last; ++column) {
        if (!is_drawn_[tile_index(column, row)]) continue;
        tiles_[static_cast<size_t>(column)].areas.push_back(place);
      }
    }
  }

  std::vector<TilePainter::Edge> edges_within(const PlanArea& area, double south) const {
    std::vector<TilePainter::Edge> edges;
    for (const Polyline& ring : area.rings) {
      for (size_t i = 0; i < ring.size(); ++i) {
        const Eigen::Vector2d& a = ring[i];
        const Eigen::Vector2d& b = ring[i + 1 == ring.size() ? 0 : i + 1];
        if (std::max(a.y(), b.y()) < south || std::min(a.y(), b.y()) > south + edge()) continue;
        edges.emplace_back(a, b);
      }
    }
    return edges;
  }

  void paint(TilePainter& painter, int column, int row) {
    const TileContent& tile = tiles_[static_cast<size_t>(column)];
    painter.begin_tile(frame_.min_corner + edge() * Eigen::Vector2d(column, row));
    painter.fill_coast(tile.pieces, strip_ids_);
    for (const uint32_t place : tile.areas) {
      const RowArea& area = row_areas_[place];
      painter.fill_area(area.edges, area_ids_[area.area].body);
    }
    painter.draw_strips(tile.pieces, strip_ids_);
    for (const uint32_t place : tile.areas) {
      const uint32_t a = row_areas_[place].area;
      if (area_ids_[a].boundary != 0) painter.draw_wall(plan_.areas[a], area_ids_[a].boundary);
    }
    for (const Joint& joint : row_contents_[static_cast<size_t>(row)].joints) {
      painter.join_levels(joint.point, joint.reach);
    }
  }

  const StreetPlan& plan_;
  RasterOptions options_;
  MapFrame frame_;
  int columns_ = 0, rows_ = 0;
  std::vector<Segment> segments_{Segment{}};
  std::vector<ElementIds> strip_ids_, area_ids_;
  std::map<std::pair<uint32_t, StreetLevels>, uint32_t> level_ids_;
  std::array<uint32_t, TilePainter::kCellsPerTile> tile_ids_{};
  std::vector<bool> is_drawn_;            // by tile
  std::vector<Box> boxes_;                // by area
  std::vector<RowContent> row_contents_;  // by row
  std::vector<TileContent> tiles_;        // of the row that is drawn
  std::vector<RowArea> row_areas_;        // of the row that is drawn
};

}  // namespace

std::optional<std::string> RasterOptions::invalid() const {
  if (!(cell_size >= 0.05 && cell_size <= 2))
    return "cell_size of a street map must be between 0.05 and 2 m";
  if (!(margin >= 0 && margin <= 1000))
    return "margin of a street map must be between 0 and 1000 m";
  if (!(corridor >= 0 && corridor <= 10000))
    return "corridor of a street map must be between 0 and 10000 m";
  if (!(max_extent > 0) || !(max_area > 0))
    return "max_extent and max_area of a street map must be positive";
  return std::nullopt;
}

Result<std::vector<std::byte>> rasterise(const StreetPlan& plan, const RasterOptions& options,
                                         std::string_view provenance,
                                         const std::function<void(double)>& progress) {
  if (const auto wrong = options.invalid()) return fail(*wrong);
  return Rasteriser(plan, options).run(provenance, progress);
}

}  // namespace infuse::streetmap
