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

/// Position of a raster. The map frame is east-north-up at the origin: x east, y north, metres.
struct MapFrame {
  bool georeferenced = false;        ///< false: made from an image, latitude and longitude are 0
  double latitude = 0;               ///< rad, WGS 84, of the origin
  double longitude = 0;              ///< rad
  double cell_size = 0.2;            ///< m, edge of a cell
  Eigen::Vector2d min_corner{0, 0};  ///< m, south-west corner of the raster

  bool operator==(const MapFrame&) const = default;  ///< of all members
};

/// Raster of segment ids, read in place from bytes that the caller keeps (read from a file):
/// nothing is copied, so a city opens at once. The raster is stored as tiles of 64 × 64 cells, each
/// with a palette of its ids and its rows as runs or as 4, 8 or 16 bits per cell; segment_map.cpp
/// defines the layout. Blocks of tiles that are open land are not stored, so that the size follows
/// the streets. A look-up is three table reads for any map size, and a short search among runs.
class SegmentMap {
 public:
  static constexpr int kTileSize = 64;  ///< cells along its edge; rows are bits of a uint64
  static constexpr int kBlockSize = 8;  ///< tiles along a block's edge, by definition of the file

  static constexpr size_t kHeaderBytes = 96;  ///< bytes before all that depends on the map

  /// An empty map: open land everywhere.
  SegmentMap() = default;

  /// Checks the first `kHeaderBytes` of a file, and that it has as many bytes as they state: what
  /// can be known before the rest is read. Errors as those of `open`.
  static Result<void> check_header(std::span<const std::byte> first, size_t file_bytes,
                                   const std::string& file);

  /// Opens a map in place. Checks all sizes, offsets and palettes that look-ups use and the
  /// checksum over all bytes; the error states what is wrong, with `file` as the location. The
  /// bytes must outlive the map and must not change.
  static Result<SegmentMap> open(std::span<const std::byte> bytes, const std::string& file);

  const MapFrame& frame() const { return frame_; }           ///< where the raster lies
  int columns() const { return tile_columns_ * kTileSize; }  ///< cells from west to east
  int rows() const { return tile_rows_ * kTileSize; }        ///< cells from south to north
  bool empty() const { return tile_columns_ == 0; }          ///< open land alone

  /// Number of segments; ids are 0 … segment_count() − 1, id 0 is open land.
  uint32_t segment_count() const { return segment_count_; }

  /// Segment of an id; open land for unknown ids.
  Segment segment(uint32_t id) const;

  /// True if a point (m, map frame) lies on the raster.
  bool covers(double x, double y) const;

  /// Segment id of a cell; 0 outside the raster.
  uint32_t id_of_cell(int column, int row) const;

  /// Segment id at a point, m; 0 outside the raster.
  uint32_t id_at(double x, double y) const;

  /// Reads the ids of neighbouring cells of a row from west to east; 0 outside the raster. Faster
  /// than single cells.
  void read_row(int first_column, int row, std::span<uint32_t> ids) const;

  /// Origin of the data, as the writer stated it.
  std::string_view provenance() const { return provenance_; }

 private:
  struct Tile {
    uint32_t offset = 0;        // of the palette, in units of 4 bytes; for a uniform tile, its id
    uint16_t palette_size = 0;  // number of ids
    uint16_t encoding = 0;      // 0: uniform, 1: runs, 4, 8 or 16: bits per cell
  };
  Tile tile_of_cell(int column, int row) const;
  uint32_t id_in_tile(const Tile& tile, uint32_t cell) const;
  void read_tile_row(const Tile& tile, uint32_t first_cell, std::span<uint32_t> ids) const;
  const char* check_tile(const Tile& tile) const;
  const char* check_tiles() const;

  MapFrame frame_;
  int tile_columns_ = 0, tile_rows_ = 0;
  uint32_t segment_count_ = 1;
  std::span<const std::byte> segments_, blocks_, tiles_, data_;
  std::string_view provenance_;
};

/// Collects tiles and writes the bytes that `SegmentMap::open` reads.
class SegmentMapWriter {
 public:
  /// A map of open land.
  SegmentMapWriter(const MapFrame& frame, int tile_columns, int tile_rows);

  /// Sets a tile, once: ids row by row from the south.
  void set_tile(int tile_column, int tile_row,
                std::span<const uint32_t, SegmentMap::kTileSize * SegmentMap::kTileSize> ids);

  /// Returns the file. `segments` are indexed by id, the first is open land. Fails if a tile refers
  /// to an unknown id, or the map is too large for the format (16 GiB of tiles).
  Result<std::vector<std::byte>> finish(std::span<const Segment> segments,
                                        std::string_view provenance) const;

 private:
  MapFrame frame_;
  int tile_columns_, tile_rows_;
  uint32_t max_id_ = 0;
  std::vector<uint32_t>
      blocks_;                   // number of the block among those that are stored, from 1; 0: none
  std::vector<uint32_t> tiles_;  // two words per tile, by block
  std::vector<uint32_t> data_;
};

}  // namespace infuse::streetmap
