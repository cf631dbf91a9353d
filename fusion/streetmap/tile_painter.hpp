#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "fusion/streetmap/segment_map.hpp"
#include "fusion/streetmap/street_plan.hpp"

namespace infuse::streetmap {

/// The ids that one element of a plan was given; 0 where it has no such part.
struct ElementIds {
  uint32_t body = 0;      ///< strip or area
  uint32_t boundary = 0;  ///< its kerb or wall
  uint32_t sidewalk = 0;  ///< its roadside
};

/// Draws the elements that touch one tile. Kept between tiles for its memory.
class TilePainter {
 public:
  static constexpr int kTileSize = SegmentMap::kTileSize;
  static constexpr int kCellsPerTile = kTileSize * kTileSize;

  /// One straight piece of a strip.
  struct Piece {
    uint32_t strip;
    uint32_t point;  ///< it goes from this point of the strip to the next
  };

  /// `cell`: m.
  TilePainter(const StreetPlan& plan, double cell) : plan_(plan), cell_size_(cell) {}

  /// Begins a tile whose south-west corner is `low`, m.
  void begin_tile(const Eigen::Vector2d& low);

  /// Draws an area's inside.
  void fill_area(const PlanArea& area, uint32_t id);

  /// Draws the pieces of strips: `ids` by strip.
  void draw_strips(std::span<const Piece> pieces, std::span<const ElementIds> ids);

  /// Draws an area's boundary line, except on carriageways.
  void draw_wall(const PlanArea& area, uint32_t id);

  std::span<const uint32_t, kCellsPerTile> ids() const { return ids_; }

 private:
  template <class Visit>
  void visit_near_line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double reach,
                       Visit visit);

  const StreetPlan& plan_;
  double cell_size_;
  Eigen::Vector2d min_corner_{0, 0};
  std::array<uint32_t, kCellsPerTile> ids_{};
  std::array<bool, kCellsPerTile>
      on_carriageway_{};  ///< drawn by a strip with a kerb, or by a crossing
  std::array<float, kCellsPerTile> edge_distance_{};  ///< m beyond the nearest carriageway's edge
  std::array<uint32_t, kCellsPerTile> nearest_strip_{};
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> edges_;  // of an area, near the tile
  std::vector<double> crossings_;
};

}  // namespace infuse::streetmap
