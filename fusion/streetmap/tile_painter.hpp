#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "fusion/streetmap/segment_map.hpp"
#include "fusion/streetmap/street_plan.hpp"

namespace infuse::streetmap {

/// Ids of one element of a plan; 0 if it has no such part.
struct ElementIds {
  uint32_t body = 0;      ///< strip or area
  uint32_t boundary = 0;  ///< kerb or wall
  uint32_t sidewalk = 0;  ///< pavement
};

/// Draws the elements of one tile. Reused for all tiles to keep its memory.
class TilePainter {
 public:
  static constexpr int kTileSize = SegmentMap::kTileSize;
  static constexpr int kCellsPerTile = kTileSize * kTileSize;

  /// One straight piece of a strip.
  struct Piece {
    uint32_t strip;
    uint32_t point;  ///< from this point of the strip to the next
  };

  /// Edge of a ring, m.
  using Edge = std::pair<Eigen::Vector2d, Eigen::Vector2d>;

  /// `cell`: m.
  TilePainter(const StreetPlan& plan, double cell) : plan_(plan), cell_size_(cell) {}

  /// Begins a tile with the south-west corner `low`, m.
  void begin_tile(const Eigen::Vector2d& low);

  /// Fills the water on the right of the coastlines among pieces of strips.
  void fill_coast(std::span<const Piece> pieces, std::span<const ElementIds> ids);

  /// Draws the inside of an area. `edges`: those of its rings that reach the tile's rows.
  void fill_area(std::span<const Edge> edges, uint32_t id);

  /// Draws pieces of strips; `ids` are indexed by strip.
  void draw_strips(std::span<const Piece> pieces, std::span<const ElementIds> ids);

  /// Draws the boundary line of an area, except on carriageways.
  void draw_wall(const PlanArea& area, uint32_t id);

  /// Marks where streets of two levels are joined: on the streets within `radius` (m) of a point.
  void join_levels(const Eigen::Vector2d& middle, double radius);

  std::span<const uint32_t, kCellsPerTile> ids() const { return ids_; }

  /// Streets on other levels than the one that is drawn.
  std::span<const StreetLevels, kCellsPerTile> levels() const { return levels_; }

 private:
  void draw_footways(std::span<const Piece> pieces, std::span<const ElementIds> ids);
  void draw_carriageways(std::span<const Piece> pieces, std::span<const ElementIds> ids, int layer);
  void mark_tunnels(std::span<const Piece> pieces);
  template <class Visit>
  void visit_near_line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double reach,
                       Visit visit);

  const StreetPlan& plan_;
  double cell_size_;
  Eigen::Vector2d min_corner_{0, 0};
  std::array<uint32_t, kCellsPerTile> ids_{};
  std::array<bool, kCellsPerTile>
      on_carriageway_{};  ///< drawn by a strip with a kerb or by a crossing
  std::array<float, kCellsPerTile>
      edge_distance_{};  ///< m outside the edge of the nearest carriageway
  std::array<uint32_t, kCellsPerTile> nearest_strip_{};
  std::array<bool, kCellsPerTile> on_left_{};    ///< of the nearest strip
  std::array<bool, kCellsPerTile> on_street_{};  ///< of a layer drawn before, not beyond its end
  std::array<bool, kCellsPerTile> on_layer_{};   ///< the same of the layer that is drawn
  std::array<StreetLevels, kCellsPerTile> levels_{};
  std::vector<double> crossings_;
  std::vector<int> layers_;  // of the tile's carriageways, ascending
};

}  // namespace infuse::streetmap
