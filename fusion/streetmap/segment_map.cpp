#include "fusion/streetmap/segment_map.hpp"

#include <zlib.h>

#include <array>
#include <cmath>

// File layout, little-endian; sections follow each other without gaps and are padded to 8 bytes:
//
//   header      kHeaderBytes, struct Header below
//   segments    16 bytes each: int64 element, uint8 kind, 7 zero bytes
//   tiles       8 bytes each, by row from the south-west: uint32 offset, uint16 palette size,
//               uint16 bits per cell
//   data        palettes (uint32 ids), each followed by its cells, in units of 4 bytes
//   provenance  text, padded with zero bytes
//
// A tile with 0 bits is uniform: its offset is the id. Of two 4-bit cells the even one is the low
// half of the byte.

namespace infuse::streetmap {
namespace {

constexpr std::array<char, 8> kMagic{'I', 'N', 'F', 'U', 'S', 'E', 'M', 'P'};
constexpr uint32_t kVersion = 2;
constexpr int kCellsPerTile = SegmentMap::kTileSize * SegmentMap::kTileSize;
constexpr int kMaxTilesPerEdge = 1 << 15;
constexpr size_t kSegmentBytes = 16;
constexpr size_t kTileBytes = 8;

struct Header {
  std::array<char, 8> magic = kMagic;
  uint32_t version = kVersion;
  uint32_t georeferenced = 0;
  double latitude = 0, longitude = 0, cell_size = 0, low_x = 0, low_y = 0;
  uint32_t tile_columns = 0, tile_rows = 0, segment_count = 0,
           provenance_bytes = 0;  // bytes
  uint64_t data_bytes = 0;        // bytes
  uint64_t checksum = 0;          // CRC-32 of the header with a checksum of 0, and of the rest
};
constexpr size_t kHeaderBytes = sizeof(Header);
static_assert(kHeaderBytes == 88);

template <class T>
T load(std::span<const std::byte> bytes, size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

constexpr size_t round_up_to_8(size_t bytes) { return (bytes + 7) / 8 * 8; }

uint64_t checksum_of(Header header, std::span<const std::byte> rest) {
  header.checksum = 0;
  const uLong first = crc32_z(0, reinterpret_cast<const Bytef*>(&header), kHeaderBytes);
  return crc32_z(first, reinterpret_cast<const Bytef*>(rest.data()), rest.size());
}

const char* header_error(const Header& header) {
  if (header.magic != kMagic) return "is not an infuse street map";
  if (header.version != kVersion) return "has an unsupported street map version";
  const auto finite = [](double value, double limit) { return std::abs(value) <= limit; };
  if (!(header.cell_size >= 0.01 && header.cell_size <= 10)) return "states an invalid cell size";
  if (!finite(header.latitude, 1.6) || !finite(header.longitude, 6.3) ||
      !finite(header.low_x, 1e7) || !finite(header.low_y, 1e7) || header.georeferenced > 1) {
    return "states an invalid frame";
  }
  if (header.tile_columns < 1 || header.tile_columns > kMaxTilesPerEdge || header.tile_rows < 1 ||
      header.tile_rows > kMaxTilesPerEdge || header.segment_count < 1 ||
      header.segment_count > (1U << 28) || header.data_bytes > (uint64_t{1} << 34) ||
      header.data_bytes % 8 != 0 || header.provenance_bytes > (1U << 20)) {
    return "states an invalid size";
  }
  return nullptr;
}

/// Bits per cell for a palette size, and words of 4 bytes for the cells of a tile.
uint16_t bits_for(size_t palette) {
  return palette <= 1 ? uint16_t{0} : palette <= 16 ? uint16_t{4} : palette <= 256 ? 8 : 16;
}
constexpr uint64_t cell_words(uint16_t bits) {
  return static_cast<uint64_t>(kCellsPerTile) * bits / 32;
}

}  // namespace

Result<SegmentMap> SegmentMap::open(std::span<const std::byte> bytes, const std::string& file) {
  const auto damaged = [&](const char* what) {
    return fail(what, file, "regenerate it with infuse streetmap");
  };
  if (bytes.size() < kHeaderBytes) return damaged("is too short for a street map");
  const auto header = load<Header>(bytes, 0);
  if (const char* wrong = header_error(header)) return damaged(wrong);
  const size_t segments = header.segment_count * kSegmentBytes;
  const size_t tiles = size_t{header.tile_columns} * header.tile_rows * kTileBytes;
  const size_t expected =
      kHeaderBytes + segments + tiles + header.data_bytes + round_up_to_8(header.provenance_bytes);
  if (bytes.size() < expected) return damaged("is truncated: bytes are missing at its end");
  if (bytes.size() > expected) return damaged("has bytes after its end");
  if (checksum_of(header, bytes.subspan(kHeaderBytes)) != header.checksum) {
    return damaged("is damaged: its checksum is wrong");
  }
  SegmentMap map;
  map.frame_ = {header.georeferenced == 1,
                header.latitude,
                header.longitude,
                header.cell_size,
                {header.low_x, header.low_y}};
  map.tile_columns_ = static_cast<int>(header.tile_columns);
  map.tile_rows_ = static_cast<int>(header.tile_rows);
  map.segment_count_ = header.segment_count;
  map.segments_ = bytes.subspan(kHeaderBytes, segments);
  map.tiles_ = bytes.subspan(kHeaderBytes + segments, tiles);
  map.data_ = bytes.subspan(kHeaderBytes + segments + tiles, header.data_bytes);
  const auto text =
      bytes.subspan(kHeaderBytes + segments + tiles + header.data_bytes, header.provenance_bytes);
  map.provenance_ = {reinterpret_cast<const char*>(text.data()), text.size()};
  if (const char* wrong = map.check_tiles()) return damaged(wrong);
  return map;
}

SegmentMap::Tile SegmentMap::tile(size_t index) const {
  const size_t at = index * kTileBytes;
  return {load<uint32_t>(tiles_, at), load<uint16_t>(tiles_, at + 4),
          load<uint16_t>(tiles_, at + 6)};
}

const char* SegmentMap::check_tiles() const {
  const uint64_t words = data_.size() / 4;
  for (size_t i = 0; i < tiles_.size() / kTileBytes; ++i) {
    const Tile t = tile(i);
    if (t.bits_per_cell == 0) {
      if (t.palette_size != 0 || t.offset >= segment_count_)
        return "has a tile with an unknown segment";
      continue;
    }
    if (t.palette_size < 2 || t.bits_per_cell != bits_for(t.palette_size))
      return "has a tile with an invalid palette";
    if (uint64_t{t.offset} + t.palette_size + cell_words(t.bits_per_cell) > words) {
      return "has a tile beyond its end";
    }
    for (size_t k = 0; k < t.palette_size; ++k) {
      if (load<uint32_t>(data_, (t.offset + k) * 4) >= segment_count_) {
        return "has a tile with an unknown segment";
      }
    }
  }
  return nullptr;
}

Segment SegmentMap::segment(uint32_t id) const {
  const size_t at = id * kSegmentBytes;
  if (id == 0 || at + kSegmentBytes > segments_.size()) return {};
  const auto kind = load<uint8_t>(segments_, at + 8);
  return {kind < kSegmentKindCount ? static_cast<SegmentKind>(kind) : SegmentKind::kOpenLand,
          load<int64_t>(segments_, at)};
}

bool SegmentMap::covers(double x, double y) const {
  const double column = (x - frame_.min_corner.x()) / frame_.cell_size;
  const double row = (y - frame_.min_corner.y()) / frame_.cell_size;
  return column >= 0 && row >= 0 && column < columns() && row < rows();
}

// A cell of a foreign file may point beyond its palette; it is then open land.
uint32_t SegmentMap::id_in_tile(const Tile& t, uint32_t cell) const {
  if (t.bits_per_cell == 0) return t.offset;
  const size_t palette = size_t{t.offset} * 4;
  const size_t cells = palette + size_t{t.palette_size} * 4;
  uint32_t index = 0;
  switch (t.bits_per_cell) {
    case 4:
      index = (load<uint8_t>(data_, cells + cell / 2) >> (cell % 2 * 4)) & 15U;
      break;
    case 8:
      index = load<uint8_t>(data_, cells + cell);
      break;
    default:
      index = load<uint16_t>(data_, cells + size_t{cell} * 2);
      break;
  }
  return index < t.palette_size ? load<uint32_t>(data_, palette + size_t{index} * 4) : 0;
}

uint32_t SegmentMap::id_of_cell(int column, int row) const {
  if (column < 0 || row < 0 || column >= columns() || row >= rows()) return 0;
  const size_t index = static_cast<size_t>(row / kTileSize) * static_cast<size_t>(tile_columns_) +
                       static_cast<size_t>(column / kTileSize);
  return id_in_tile(tile(index),
                    static_cast<uint32_t>(row % kTileSize * kTileSize + column % kTileSize));
}

uint32_t SegmentMap::id_at(double x, double y) const {
  if (!covers(x, y)) return 0;
  return id_of_cell(static_cast<int>((x - frame_.min_corner.x()) / frame_.cell_size),
                    static_cast<int>((y - frame_.min_corner.y()) / frame_.cell_size));
}

void SegmentMap::read_tile(int tile_column, int tile_row,
                           std::span<uint32_t, kTileSize * kTileSize> ids) const {
  const Tile t = tile(static_cast<size_t>(tile_row) * static_cast<size_t>(tile_columns_) +
                      static_cast<size_t>(tile_column));
  for (uint32_t cell = 0; cell < kCellsPerTile; ++cell) ids[cell] = id_in_tile(t, cell);
}

// --- writing ---

SegmentMapWriter::SegmentMapWriter(const MapFrame& frame, int tile_columns, int tile_rows)
    : frame_(frame), tile_columns_(tile_columns), tile_rows_(tile_rows) {}

void SegmentMapWriter::add_tile(
    std::span<const uint32_t, SegmentMap::kTileSize * SegmentMap::kTileSize> ids) {
  std::vector<uint32_t> palette;
  std::array<uint16_t, kCellsPerTile> cells{};
  for (size_t i = 0; i < kCellsPerTile; ++i) {
    if (i > 0 && ids[i] == ids[i - 1]) {
      cells[i] = cells[i - 1];
      continue;
    }
    size_t k = 0;
    while (k < palette.size() && palette[k] != ids[i]) ++k;
    if (k == palette.size()) palette.push_back(ids[i]);
    cells[i] = static_cast<uint16_t>(k);
    max_id_ = std::max(max_id_, ids[i]);
  }
  const uint16_t bits = bits_for(palette.size());
  if (bits == 0) {
    tiles_.insert(tiles_.end(), {palette[0], 0});
    return;
  }
  tiles_.insert(tiles_.end(), {static_cast<uint32_t>(data_.size()),
                               static_cast<uint32_t>(palette.size()) | uint32_t{bits} << 16});
  data_.insert(data_.end(), palette.begin(), palette.end());
  const size_t per_word = 32U / bits;
  for (size_t i = 0; i < kCellsPerTile; i += per_word) {
    uint32_t word = 0;
    for (size_t k = 0; k < per_word; ++k) word |= uint32_t{cells[i + k]} << (k * bits);
    data_.push_back(word);
  }
}

Result<std::vector<std::byte>> SegmentMapWriter::finish(std::span<const Segment> segments,
                                                        std::string_view provenance) const {
  const size_t tiles = static_cast<size_t>(tile_columns_) * static_cast<size_t>(tile_rows_);
  if (tiles_.size() != tiles * 2) return fail("the map is incomplete: tiles were not added");
  if (max_id_ >= segments.size()) return fail("a tile refers to an unknown segment");
  Header header{.georeferenced = frame_.georeferenced ? 1U : 0U,
                .latitude = frame_.latitude,
                .longitude = frame_.longitude,
                .cell_size = frame_.cell_size,
                .low_x = frame_.min_corner.x(),
                .low_y = frame_.min_corner.y(),
                .tile_columns = static_cast<uint32_t>(tile_columns_),
                .tile_rows = static_cast<uint32_t>(tile_rows_),
                .segment_count = static_cast<uint32_t>(segments.size()),
                .provenance_bytes = static_cast<uint32_t>(provenance.size()),
                .data_bytes = round_up_to_8(data_.size() * 4)};
  if (const char* wrong = header_error(header)) {
    return fail(std::string("the map ") + wrong, {}, "choose larger cells or a smaller area");
  }
  const size_t segment_bytes = segments.size() * kSegmentBytes;
  std::vector<std::byte> file(kHeaderBytes + segment_bytes + tiles_.size() * 4 + header.data_bytes +
                              round_up_to_8(provenance.size()));
  size_t at = kHeaderBytes;
  for (const Segment& segment : segments) {
    std::memcpy(file.data() + at, &segment.osm_id, sizeof segment.osm_id);
    file[at + 8] = static_cast<std::byte>(segment.kind);
    at += kSegmentBytes;
  }
  const auto append = [&](const void* from, size_t bytes) {
    if (bytes > 0) std::memcpy(file.data() + at, from, bytes);
    at += round_up_to_8(bytes);
  };
  append(tiles_.data(), tiles_.size() * 4);
  append(data_.data(), data_.size() * 4);
  append(provenance.data(), provenance.size());
  header.checksum = checksum_of(header, std::span(file).subspan(kHeaderBytes));
  std::memcpy(file.data(), &header, sizeof header);
  return file;
}

}  // namespace infuse::streetmap
