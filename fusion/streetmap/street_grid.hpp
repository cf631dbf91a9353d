#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "fusion/streetmap/planar_pose.hpp"
#include "fusion/streetmap/segment_map.hpp"

namespace infuse::streetmap {

/// The street across a pose: the interval of ground that is street, m to the left of the pose.
struct StreetProfile {
  double right = 0;  ///< lower end
  double left = 0;   ///< upper end

  double centre() const { return (left + right) / 2; }
  double half_width() const { return (left - right) / 2; }
  /// Distance of the pose from the street, m; 0 on it.
  double distance() const { return right > 0 ? right : left < 0 ? -left : 0; }
};

/// Where a map has streets: a cell for each square metre, in tiles of which those without streets
/// are not stored, so that a city of 300 km² fits in 200 MB and millions of look-ups a second are
/// cheap. A street keeps its level: from a bridge no way leads to the street below but at its ends.
class StreetGrid {
 public:
  static constexpr int kAnyLevel = 100;      ///< by definition: not known, or two levels are joined
  static constexpr int kBelowGround = -100;  ///< by definition: in a tunnel
  static constexpr double kCell = 1;         ///< m, edge of a cell
  static constexpr double kMaxArea = 1e9;    ///< m², of a map that can be read: bounds memory
  static constexpr size_t kMaxMixed = 1 << 20;  ///< bounds memory: 64 MB
  static constexpr double kProfileReach = 16;   ///< m to either side

  /// No streets.
  StreetGrid() = default;

  /// Reads the carriageways and crossings of a map; empty if it is larger than `kMaxArea`, or if
  /// more than `kMaxMixed` tiles have streets of several levels.
  explicit StreetGrid(const SegmentMap& map);

  bool empty() const { return columns_ == 0; }
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  /// Middle of a cell, m, map frame.
  Eigen::Vector2d middle(int column, int row) const;

  /// True if a point (m, map frame) lies on a street of a level (`PlanStrip::layer`, or one of the
  /// above).
  bool street(double x, double y, int level = kAnyLevel) const;

  /// Level after a way from a point to another (m, map frame), begun at `level`.
  int level_after(int level, const Eigen::Vector2d& from, const Eigen::Vector2d& to) const;

  /// Distance from the pose to where the street ends along its heading, m, up to `reach`; 0 beside
  /// streets.
  double free_length(const PlanarPose& pose, double reach) const;

  /// The street of a level that is nearest to the pose across its heading; nothing within
  /// `kProfileReach`.
  std::optional<StreetProfile> across(const PlanarPose& pose, int level = kAnyLevel) const;

 private:
  uint8_t cell(double x, double y) const;
  bool joined_between(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const;

  double low_x_ = 0, low_y_ = 0;  // m
  int columns_ = 0, rows_ = 0;
  bool has_levels_ = false;  // more than one
  /// 8 × 8 cells: where there is a street, and what, if it is the same in all of them.
  struct Tile {
    uint64_t streets = 0;
    uint32_t mixed = 0;  // its cells; 0: they are alike
    uint8_t cell = 0;    // the layer + 16 in the upper five bits, and what there is
  };
  static constexpr size_t kEdge = 8;  // cells: a tile has 64 bits
  using Cells = std::array<uint8_t, kEdge * kEdge>;
  void add_tile(size_t index, const Cells& cells);

  size_t tile_columns_ = 0;
  std::vector<uint32_t> tile_at_;  // 0: without streets
  std::vector<Tile> tiles_;        // the first is empty
  std::vector<Cells> mixed_;       // the first is not used
};

}  // namespace infuse::streetmap
