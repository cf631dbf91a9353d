#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "fusion/streetmap/segment.hpp"

namespace infuse::streetmap {

/// Where a map's raster lies. Its frame is east-north-up at the origin; x east, y north, metres.
struct MapFrame {
  bool georeferenced = false;  ///< false: the map came from an image, latitude and longitude are 0
  double latitude = 0;         ///< rad, WGS 84, of the origin
  double longitude = 0;        ///< rad
  double cell_size = 0.2;      ///< m, edge of a cell
  Eigen::Vector2d min_corner{0, 0};  ///< m, south-west corner of the raster

  bool operator==(const MapFrame&) const = default;
};

/// A raster of segment ids, read in place from bytes that somebody else keeps (a file mapped into
/// memory): nothing is copied, so a city is there at once. The bytes are 64 × 64 tiles of cells,
/// each with a palette of the ids that occur in it and 0, 4, 8 or 16 bits a cell; segment_map.cpp
/// states the layout. A look-up is two table reads whatever the size of the map.
class SegmentMap {
 public:
  static constexpr int kTileSize = 64;  ///< cells along a tile's edge

  /// An empty map: open land everywhere.
  SegmentMap() = default;

  /// Reads a map in place. Checks everything that look-ups rely on (sizes, offsets, palettes) and
  /// the checksum over all bytes; fails with what is wrong and `file` as the place. The bytes must
  /// outlive the map and stay as they are.
  static Result<SegmentMap> open(std::span<const std::byte> bytes, const std::string& file);

  const MapFrame& frame() const { return frame_; }
  int columns() const { return tile_columns_ * kTileSize; }  ///< cells from west to east
  int rows() const { return tile_rows_ * kTileSize; }        ///< cells from south to north
  bool empty() const { return tile_columns_ == 0; }

  /// Number of segments; ids are 0 … segments() − 1, 0 being open land.
  uint32_t segment_count() const { return segment_count_; }

  /// What an id stands for; open land for ids that do not exist.
  Segment segment(uint32_t id) const;

  /// Whether a place (m, map frame) lies on the raster.
  bool covers(double x, double y) const;

  /// The segment id of a cell; 0 outside the raster.
  uint32_t id_of_cell(int column, int row) const;

  /// The segment id at a place, m; 0 outside the raster.
  uint32_t id_at(double x, double y) const;

  /// One tile's ids, row by row from the south.
  void read_tile(int tile_column, int tile_row,
                 std::span<uint32_t, kTileSize * kTileSize> ids) const;

  /// Where the map came from, as its maker wrote it.
  std::string_view provenance() const { return provenance_; }

 private:
  struct Tile {
    uint32_t offset = 0;         // of the palette, in units of 4 bytes; of a uniform tile, its id
    uint16_t palette_size = 0;   // ids in it
    uint16_t bits_per_cell = 0;  // a cell: 0, 4, 8 or 16
  };
  Tile tile(size_t index) const;
  uint32_t id_in_tile(const Tile& tile, uint32_t cell) const;
  const char* check_tiles() const;

  MapFrame frame_;
  int tile_columns_ = 0, tile_rows_ = 0;
  uint32_t segment_count_ = 1;
  std::span<const std::byte> segments_, tiles_, data_;
  std::string_view provenance_;
};

/// Collects tiles and makes the bytes that `SegmentMap::open` reads.
class SegmentMapWriter {
 public:
  /// Tiles follow by row from the south-west corner: `add_tile` is to be called
  /// tile_columns · tile_rows times.
  SegmentMapWriter(const MapFrame& frame, int tile_columns, int tile_rows);

  /// The next tile's ids, row by row from the south.
  void add_tile(std::span<const uint32_t, SegmentMap::kTileSize * SegmentMap::kTileSize> ids);

  /// The file. `segments` by id, the first open land; fails where a tile refers to an id that is
  /// not there, tiles are missing, or the map is too large for the format (16 GiB of tiles).
  Result<std::vector<std::byte>> finish(std::span<const Segment> segments,
                                        std::string_view provenance) const;

 private:
  MapFrame frame_;
  int tile_columns_, tile_rows_;
  uint32_t max_id_ = 0;
  std::vector<uint32_t> tiles_;  // two words a tile
  std::vector<uint32_t> data_;
};

}  // namespace infuse::streetmap
