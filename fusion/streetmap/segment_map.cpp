#include "fusion/streetmap/segment_map.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

// File layout, little-endian; sections follow each other without gaps and are padded to 8 bytes:
//
//   header      kHeaderBytes, struct Header below
//   segments    16 bytes each: int64 element, uint8 kind, int8 layer, uint8 levels, 5 zero bytes
//   blocks      uint32 per block of 8 × 8 tiles, by row from the south-west: its number among the
//               blocks that are stored, from 1; 0: open land
//   tiles       of the stored blocks, by row from the south-west: uint32 offset, uint16 palette
//               size, uint16 encoding
//   data        palettes (uint32 ids), each followed by its cells, in units of 4 bytes
//   provenance  text, padded with zero bytes
//
// A tile of encoding 0 is uniform: its offset is the id. Encodings 4, 8 and 16 are bits per cell;
// of two 4-bit cells the even one is the low half of the byte. Encoding 1 are runs, if that is
// smaller: a uint64 whose bits mark the rows that differ from the row below (the first is marked),
// for each of them a uint16 with its first run, and the runs. A run is a uint16: its last column in
// the lower 6 bits, its place in the palette above; the last run of a row ends at column 63.

namespace infuse::streetmap {
namespace {

constexpr std::array<char, 8> kMagic{'I', 'N', 'F', 'U', 'S', 'E', 'M', 'P'};
constexpr uint32_t kVersion = 3;  // of the file, by definition
constexpr int kCellsPerTile = SegmentMap::kTileSize * SegmentMap::kTileSize;
constexpr int kMaxTilesPerEdge = 1 << 15;  // bounds input
constexpr size_t kSegmentBytes = 16;       // bytes of an entry
constexpr size_t kTileBytes = 8;           // bytes of an entry
constexpr int kTilesPerBlock = SegmentMap::kBlockSize * SegmentMap::kBlockSize;
constexpr uint16_t kRuns = 1;               // encoding, by definition
constexpr size_t kMaxRunPalette = 1 << 10;  // ids that a run can name in 10 bits

struct Header {
  std::array<char, 8> magic = kMagic;
  uint32_t version = kVersion;
  uint32_t georeferenced = 0;
  double latitude = 0, longitude = 0, cell_size = 0, low_x = 0, low_y = 0;
  uint32_t tile_columns = 0, tile_rows = 0, segment_count = 0,
           provenance_bytes = 0;  // bytes
  uint32_t stored_blocks = 0, reserved = 0;
  uint64_t data_bytes = 0;  // bytes
  uint64_t checksum = 0;    // CRC-32 of the header with a checksum of 0, and of the rest
};
constexpr size_t kHeaderBytes = SegmentMap::kHeaderBytes;
static_assert(kHeaderBytes == sizeof(Header));

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

constexpr size_t blocks_along(size_t tiles) {
  return (tiles + SegmentMap::kBlockSize - 1) / SegmentMap::kBlockSize;
}
constexpr size_t block_count(size_t tile_columns, size_t tile_rows) {
  return blocks_along(tile_columns) * blocks_along(tile_rows);
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
      header.data_bytes % 8 != 0 || header.provenance_bytes > (1U << 20) ||
      header.stored_blocks > block_count(header.tile_columns, header.tile_rows)) {
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

/// Runs of a tile, in place.
class Runs {
 public:
  /// `at`: offset in `data` of the first byte after the palette.
  Runs(std::span<const std::byte> data, size_t at) : data_(data), at_(at) {}

  static constexpr size_t kMarkBytes = sizeof(uint64_t);
  uint64_t marks() const { return load<uint64_t>(data_, at_); }
  size_t distinct_rows() const { return static_cast<size_t>(std::popcount(marks())); }
  size_t bytes_before_runs() const { return kMarkBytes + 2 * distinct_rows(); }

  /// Offset in `data` of the first run of a row.
  size_t first_run(uint32_t row) const {
    const uint64_t up_to_row = marks() & (~uint64_t{0} >> (63 - row));
    const size_t distinct = static_cast<size_t>(std::popcount(up_to_row)) - 1;
    const auto first = load<uint16_t>(data_, at_ + kMarkBytes + 2 * distinct);
    return at_ + bytes_before_runs() + size_t{2} * first;
  }

  /// True if all rows lie within `data` and each ends at the last column.
  bool valid() const {
    if (at_ + kMarkBytes > data_.size() || (marks() & 1U) == 0) return false;
    const size_t rows = distinct_rows(), runs = at_ + bytes_before_runs();
    size_t count = 0;
    for (size_t row = 0; row < rows; ++row) {
      const size_t start = at_ + kMarkBytes + 2 * row;
      if (start + 2 > data_.size() || load<uint16_t>(data_, start) != count) return false;
      for (int end = -1, next = 0; end < SegmentMap::kTileSize - 1; end = next, ++count) {
        if (runs + 2 * count + 2 > data_.size()) return false;
        next = load<uint16_t>(data_, runs + 2 * count) & 63;
        if (next <= end) return false;
      }
    }
    return true;
  }

 private:
  std::span<const std::byte> data_;
  size_t at_;
};

/// Encodes cells (places in the palette) as runs, in words of 4 bytes.
std::vector<uint32_t> encode_runs(std::span<const uint16_t, kCellsPerTile> cells) {
  constexpr size_t kEdge = SegmentMap::kTileSize;
  uint64_t marks = 0;
  std::vector<uint16_t> starts, runs;
  for (size_t row = 0; row < kEdge; ++row) {
    const auto current = cells.subspan(row * kEdge, kEdge);
    if (row > 0 && std::equal(current.begin(), current.end(), current.begin() - kEdge)) continue;
    marks |= uint64_t{1} << row;
    starts.push_back(static_cast<uint16_t>(runs.size()));
    for (size_t column = 0; column < kEdge; ++column) {
      if (column + 1 < kEdge && current[column + 1] == current[column]) continue;
      runs.push_back(static_cast<uint16_t>(column | size_t{current[column]} << 6U));
    }
  }
  starts.insert(starts.end(), runs.begin(), runs.end());
  if (starts.size() % 2 != 0) starts.push_back(0);
  std::vector<uint32_t> words(2 + starts.size() / 2);
  std::memcpy(words.data(), &marks, sizeof marks);
  std::memcpy(words.data() + 2, starts.data(), starts.size() * 2);
  return words;
}

tl::unexpected<Error> damaged(const char* what, const std::string& file) {
  return fail(what, file, "regenerate it with infuse streetmap");
}

/// Sizes of the sections that a header states, bytes.
struct Sections {
  explicit Sections(const Header& header)
      : segments(header.segment_count * kSegmentBytes),
        blocks(block_count(header.tile_columns, header.tile_rows) * 4),
        tiles(size_t{header.stored_blocks} * kTilesPerBlock * kTileBytes),
        before_tiles(kHeaderBytes + segments + round_up_to_8(blocks)),
        file(before_tiles + tiles + header.data_bytes + round_up_to_8(header.provenance_bytes)) {}

  size_t segments, blocks, tiles, before_tiles, file;
};

}  // namespace

Result<void> SegmentMap::check_header(std::span<const std::byte> first, size_t file_bytes,
                                      const std::string& file) {
  if (first.size() < kHeaderBytes) return damaged("is too short for a street map", file);
  const auto header = load<Header>(first, 0);
  if (const char* wrong = header_error(header)) return damaged(wrong, file);
  const size_t stated = Sections(header).file;
  if (file_bytes < stated) return damaged("is truncated: bytes are missing at its end", file);
  if (file_bytes > stated) return damaged("has bytes after its end", file);
  return {};
}

Result<SegmentMap> SegmentMap::open(std::span<const std::byte> bytes, const std::string& file) {
  if (const auto checked = check_header(bytes, bytes.size(), file); !checked) {
    return tl::unexpected(checked.error());
  }
  const auto header = load<Header>(bytes, 0);
  const Sections sections(header);
  if (checksum_of(header, bytes.subspan(kHeaderBytes)) != header.checksum) {
    return damaged("is damaged: its checksum is wrong", file);
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
  const size_t data = sections.before_tiles + sections.tiles;
  map.segments_ = bytes.subspan(kHeaderBytes, sections.segments);
  map.blocks_ = bytes.subspan(kHeaderBytes + sections.segments, sections.blocks);
  map.tiles_ = bytes.subspan(sections.before_tiles, sections.tiles);
  map.data_ = bytes.subspan(data, header.data_bytes);
  const auto text = bytes.subspan(data + header.data_bytes, header.provenance_bytes);
  map.provenance_ = {reinterpret_cast<const char*>(text.data()), text.size()};
  if (const char* wrong = map.check_tiles()) return damaged(wrong, file);
  return map;
}

SegmentMap::Tile SegmentMap::tile_of_cell(int column, int row) const {
  constexpr size_t kEdge = kBlockSize;
  const auto tile_column = static_cast<size_t>(column / kTileSize);
  const auto tile_row = static_cast<size_t>(row / kTileSize);
  const size_t blocks = blocks_along(static_cast<size_t>(tile_columns_));
  const auto block = load<uint32_t>(blocks_, (tile_row / kEdge * blocks + tile_column / kEdge) * 4);
  if (block == 0) return {};
  const size_t index =
      (block - size_t{1}) * kTilesPerBlock + tile_row % kEdge * kEdge + tile_column % kEdge;
  const size_t at = index * kTileBytes;
  return {load<uint32_t>(tiles_, at), load<uint16_t>(tiles_, at + 4),
          load<uint16_t>(tiles_, at + 6)};
}

const char* SegmentMap::check_tile(const Tile& tile) const {
  if (tile.encoding == 0) {
    if (tile.palette_size == 0 && tile.offset < segment_count_) return nullptr;
    return "has a tile with an unknown segment";
  }
  const bool runs = tile.encoding == kRuns;
  if (tile.palette_size < 2 ||
      (runs ? tile.palette_size > kMaxRunPalette : tile.encoding != bits_for(tile.palette_size))) {
    return "has a tile with an invalid palette";
  }
  const uint64_t words = data_.size() / 4;
  const uint64_t cells = uint64_t{tile.offset} + tile.palette_size;
  if (cells + (runs ? 0 : cell_words(tile.encoding)) > words) return "has a tile beyond its end";
  if (runs && !Runs(data_, cells * 4).valid()) return "has a tile with invalid runs";
  for (size_t k = 0; k < tile.palette_size; ++k) {
    if (load<uint32_t>(data_, (tile.offset + k) * 4) >= segment_count_) {
      return "has a tile with an unknown segment";
    }
  }
  return nullptr;
}

const char* SegmentMap::check_tiles() const {
  const size_t stored = tiles_.size() / (kTilesPerBlock * kTileBytes);
  for (size_t i = 0; i < blocks_.size(); i += 4) {
    if (load<uint32_t>(blocks_, i) > stored) return "has a block beyond its end";
  }
  for (size_t at = 0; at < tiles_.size(); at += kTileBytes) {
    const Tile tile{load<uint32_t>(tiles_, at), load<uint16_t>(tiles_, at + 4),
                    load<uint16_t>(tiles_, at + 6)};
    if (const char* wrong = check_tile(tile)) return wrong;
  }
  return nullptr;
}

Segment SegmentMap::segment(uint32_t id) const {
  const size_t at = id * kSegmentBytes;
  if (id == 0 || at + kSegmentBytes > segments_.size()) return {};
  const auto kind = load<uint8_t>(segments_, at + 8), levels = load<uint8_t>(segments_, at + 10);
  return {kind < kSegmentKindCount ? static_cast<SegmentKind>(kind) : SegmentKind::kOpenLand,
          load<int64_t>(segments_, at), load<int8_t>(segments_, at + 9),
          levels <= static_cast<uint8_t>(StreetLevels::kJoined) ? static_cast<StreetLevels>(levels)
                                                                : StreetLevels::kOne};
}

bool SegmentMap::covers(double x, double y) const {
  const double column = (x - frame_.min_corner.x()) / frame_.cell_size;
  const double row = (y - frame_.min_corner.y()) / frame_.cell_size;
  return column >= 0 && row >= 0 && column < columns() && row < rows();
}

// A cell of a foreign file may point beyond its palette; it is then open land.
uint32_t SegmentMap::id_in_tile(const Tile& t, uint32_t cell) const {
  if (t.encoding == 0) return t.offset;
  if (t.encoding == kRuns) {
    uint32_t id = 0;
    read_tile_row(t, cell, {&id, 1});
    return id;
  }
  const size_t palette = size_t{t.offset} * 4;
  const size_t cells = palette + size_t{t.palette_size} * 4;
  uint32_t index = 0;
  switch (t.encoding) {
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

void SegmentMap::read_tile_row(const Tile& t, uint32_t first_cell, std::span<uint32_t> ids) const {
  if (t.encoding != kRuns) {
    for (uint32_t& id : ids) id = id_in_tile(t, first_cell++);
    return;
  }
  const size_t palette = size_t{t.offset} * 4;
  size_t run = Runs(data_, palette + size_t{t.palette_size} * 4).first_run(first_cell / kTileSize);
  const uint32_t column = first_cell % kTileSize;
  for (size_t at = 0; at < ids.size(); run += 2) {
    const auto code = load<uint16_t>(data_, run);
    const size_t end = (code & 63U) + size_t{1};
    if (end <= column) continue;
    const size_t index = code >> 6U;
    const uint32_t id = index < t.palette_size ? load<uint32_t>(data_, palette + index * 4) : 0;
    for (; at < std::min(end - column, ids.size()); ++at) ids[at] = id;
  }
}

uint32_t SegmentMap::id_of_cell(int column, int row) const {
  if (column < 0 || row < 0 || column >= columns() || row >= rows()) return 0;
  return id_in_tile(tile_of_cell(column, row),
                    static_cast<uint32_t>(row % kTileSize * kTileSize + column % kTileSize));
}

void SegmentMap::read_row(int first_column, int row, std::span<uint32_t> ids) const {
  std::fill(ids.begin(), ids.end(), 0U);
  if (row < 0 || row >= rows()) return;
  const int64_t wanted = first_column + static_cast<int64_t>(ids.size());
  const int end = static_cast<int>(std::min<int64_t>(wanted, columns()));
  for (int column = std::max(first_column, 0); column < end;) {
    const int next = std::min(end, (column / kTileSize + 1) * kTileSize);
    read_tile_row(tile_of_cell(column, row),
                  static_cast<uint32_t>(row % kTileSize * kTileSize + column % kTileSize),
                  ids.subspan(static_cast<size_t>(column - first_column),
                              static_cast<size_t>(next - column)));
    column = next;
  }
}

uint32_t SegmentMap::id_at(double x, double y) const {
  if (!covers(x, y)) return 0;
  return id_of_cell(static_cast<int>((x - frame_.min_corner.x()) / frame_.cell_size),
                    static_cast<int>((y - frame_.min_corner.y()) / frame_.cell_size));
}

// --- writing ---

SegmentMapWriter::SegmentMapWriter(const MapFrame& frame, int tile_columns, int tile_rows)
    : frame_(frame),
      tile_columns_(tile_columns),
      tile_rows_(tile_rows),
      blocks_(block_count(static_cast<size_t>(tile_columns), static_cast<size_t>(tile_rows))) {}

void SegmentMapWriter::set_tile(
    int tile_column, int tile_row,
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
  if (palette.size() == 1 && palette[0] == 0) return;
  constexpr size_t kEdge = SegmentMap::kBlockSize;
  const auto column = static_cast<size_t>(tile_column), row = static_cast<size_t>(tile_row);
  const size_t blocks = blocks_along(static_cast<size_t>(tile_columns_));
  uint32_t& block = blocks_[row / kEdge * blocks + column / kEdge];
  if (block == 0) {
    tiles_.resize(tiles_.size() + size_t{2} * kTilesPerBlock);
    block = static_cast<uint32_t>(tiles_.size() / (size_t{2} * kTilesPerBlock));
  }
  const size_t tile =
      2 * ((block - size_t{1}) * kTilesPerBlock + row % kEdge * kEdge + column % kEdge);
  if (palette.size() == 1) {
    tiles_[tile] = palette[0];
    return;
  }
  const uint16_t bits = bits_for(palette.size());
  const std::vector<uint32_t> runs = encode_runs(cells);
  const bool as_runs = palette.size() <= kMaxRunPalette && runs.size() < cell_words(bits);
  tiles_[tile] = static_cast<uint32_t>(data_.size());
  tiles_[tile + 1] = static_cast<uint32_t>(palette.size()) | uint32_t{as_runs ? kRuns : bits}
                                                                 << 16U;
  data_.insert(data_.end(), palette.begin(), palette.end());
  if (as_runs) {
    data_.insert(data_.end(), runs.begin(), runs.end());
    return;
  }
  const size_t per_word = 32U / bits;
  for (size_t i = 0; i < kCellsPerTile; i += per_word) {
    uint32_t word = 0;
    for (size_t k = 0; k < per_word; ++k) word |= uint32_t{cells[i + k]} << (k * bits);
    data_.push_back(word);
  }
}

Result<std::vector<std::byte>> SegmentMapWriter::finish(std::span<const Segment> segments,
                                                        std::string_view provenance) const {
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
                .stored_blocks = static_cast<uint32_t>(tiles_.size() / (2 * kTilesPerBlock)),
                .data_bytes = round_up_to_8(data_.size() * 4)};
  if (const char* wrong = header_error(header)) {
    return fail(std::string("the map ") + wrong, {}, "choose larger cells or a smaller area");
  }
  const size_t segment_bytes = segments.size() * kSegmentBytes;
  std::vector<std::byte> file(kHeaderBytes + segment_bytes + round_up_to_8(blocks_.size() * 4) +
                              tiles_.size() * 4 + header.data_bytes +
                              round_up_to_8(provenance.size()));
  size_t at = kHeaderBytes;
  for (const Segment& segment : segments) {
    std::memcpy(file.data() + at, &segment.osm_id, sizeof segment.osm_id);
    file[at + 8] = static_cast<std::byte>(segment.kind);
    file[at + 9] = static_cast<std::byte>(segment.layer);
    file[at + 10] = static_cast<std::byte>(segment.levels);
    at += kSegmentBytes;
  }
  const auto append = [&](const void* from, size_t bytes) {
    if (bytes > 0) std::memcpy(file.data() + at, from, bytes);
    at += round_up_to_8(bytes);
  };
  append(blocks_.data(), blocks_.size() * 4);
  append(tiles_.data(), tiles_.size() * 4);
  append(data_.data(), data_.size() * 4);
  append(provenance.data(), provenance.size());
  header.checksum = checksum_of(header, std::span(file).subspan(kHeaderBytes));
  std::memcpy(file.data(), &header, sizeof header);
  return file;
}

}  // namespace infuse::streetmap
