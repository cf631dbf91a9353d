#include "fusion/streetmap/segment_map.hpp"

#include <gtest/gtest.h>
#include <zlib.h>

#include <array>
#include <random>

namespace infuse::streetmap {
namespace {

constexpr int kTileSize = SegmentMap::kTileSize;
using Tile = std::array<uint32_t, kTileSize * kTileSize>;

/// Tiles of one, several, many and very many ids: every number of bits per cell.
std::vector<Tile> make_tiles() {
  std::mt19937 random(7);
  std::vector<Tile> tiles;
  for (const uint32_t ids : {1U, 2U, 16U, 17U, 256U, 257U}) {
    Tile& tile = tiles.emplace_back();
    for (size_t i = 0; i < tile.size(); ++i) tile[i] = 3 + static_cast<uint32_t>(random()) % ids;
    for (uint32_t k = 0; k < ids; ++k) tile[k * 3] = 3 + k;
  }
  return tiles;
}

const MapFrame kFrame{true, 0.85, 0.14, 0.25, {-40, 12.5}};

std::vector<Segment> segments() {
  std::vector<Segment> list(300);
  for (size_t i = 1; i < list.size(); ++i) {
    list[i] = {static_cast<SegmentKind>(1 + i % 12), -static_cast<int64_t>(i) << 33};
  }
  return list;
}

std::vector<std::byte> make_file(const std::vector<Tile>& tiles) {
  SegmentMapWriter writer(kFrame, 3, 2);
  for (int i = 0; i < 6; ++i) writer.set_tile(i % 3, i / 3, tiles[static_cast<size_t>(i)]);
  auto bytes = writer.finish(segments(), "made for a test");
  EXPECT_TRUE(bytes);
  return bytes.value_or(std::vector<std::byte>());
}

/// Writes a number into a file and corrects its checksum, as an attacker could.
template <class T>
std::vector<std::byte> forge(std::vector<std::byte> bytes, size_t offset, T value) {
  std::memcpy(bytes.data() + offset, &value, sizeof value);
  const uint64_t zero = 0;
  std::memcpy(bytes.data() + 88, &zero, 8);
  const uint64_t sum = crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
  std::memcpy(bytes.data() + 88, &sum, 8);
  return bytes;
}

TEST(SegmentMap, ReturnsEveryCell) {
  const auto tiles = make_tiles();
  const auto bytes = make_file(tiles);
  const auto map = SegmentMap::open(bytes, "x.map");
  ASSERT_TRUE(map) << map.error().message();
  ASSERT_EQ(map->columns(), 3 * kTileSize);
  ASSERT_EQ(map->rows(), 2 * kTileSize);
  EXPECT_EQ(map->frame(), kFrame);
  EXPECT_EQ(map->provenance(), "made for a test");
  for (int row = 0; row < map->rows(); ++row) {
    for (int column = 0; column < map->columns(); ++column) {
      const Tile& tile = tiles[static_cast<size_t>(row / kTileSize * 3 + column / kTileSize)];
      const uint32_t expected =
          tile[static_cast<size_t>(row % kTileSize * kTileSize + column % kTileSize)];
      ASSERT_EQ(map->id_of_cell(column, row), expected) << column << " " << row;
      const double x = -40 + (column + 0.5) * 0.25, y = 12.5 + (row + 0.5) * 0.25;
      ASSERT_EQ(map->id_at(x, y), expected);
    }
  }
  std::vector<uint32_t> ids(200);
  for (const int row : {-1, 0, 70, 127, 128}) {
    for (const int first : {-3, 0, 60, 150, 1000}) {
      map->read_row(first, row, ids);
      for (int i = 0; i < 200; ++i) {
        ASSERT_EQ(ids[static_cast<size_t>(i)], map->id_of_cell(first + i, row))
            << first << " " << i;
      }
    }
  }
  for (uint32_t id = 0; id < 300; ++id) EXPECT_EQ(map->segment(id), segments()[id]);
}

TEST(SegmentMap, IsOpenLandOutsideAndForUnknownIds) {
  const auto bytes = make_file(make_tiles());
  const auto map = SegmentMap::open(bytes, "x.map");
  ASSERT_TRUE(map);
  EXPECT_FALSE(map->covers(-40.01, 20));
  EXPECT_TRUE(map->covers(-39.99, 20));
  for (const double x : {-41.0, 1e300, -1e300, double(NAN)}) EXPECT_EQ(map->id_at(x, 20), 0U);
  EXPECT_EQ(map->id_of_cell(-1, 0), 0U);
  EXPECT_EQ(map->segment(300), Segment{});
  EXPECT_EQ(map->segment(UINT32_MAX), Segment{});
  EXPECT_EQ(SegmentMap().id_at(0, 0), 0U);
}

TEST(SegmentMap, RejectsTruncatedAndLongerFiles) {
  auto bytes = make_file(make_tiles());
  for (size_t length = 0; length < bytes.size(); length += length < 200 ? 1 : 997) {
    EXPECT_FALSE(SegmentMap::open(std::span(bytes).first(length), "x.map")) << length;
  }
  bytes.resize(bytes.size() + 8);
  const auto longer = SegmentMap::open(bytes, "x.map");
  ASSERT_FALSE(longer);
  EXPECT_EQ(longer.error().message(),
            "x.map: has bytes after its end (regenerate it with infuse streetmap)");
}

TEST(SegmentMap, FindsAChangedBit) {
  const auto bytes = make_file(make_tiles());
  std::mt19937 random(3);
  for (int i = 0; i < 400; ++i) {
    auto changed = bytes;
    const size_t at = i < 96 ? static_cast<size_t>(i) : random() % bytes.size();
    changed[at] ^= static_cast<std::byte>(1U << random() % 8);
    EXPECT_FALSE(SegmentMap::open(changed, "x.map")) << "byte " << at;
  }
}

TEST(SegmentMap, SurvivesForgedTables) {
  const auto bytes = make_file(make_tiles());
  const size_t tiles = 96 + 300 * 16 + 8;  // one block
  const auto second = tiles + 8;
  EXPECT_TRUE(
      SegmentMap::open(forge(bytes, 88, uint64_t{0}), "x"));  // only the checksum is corrected
  EXPECT_FALSE(SegmentMap::open(forge(bytes, second, uint32_t{0xFFFFFFF0}), "x"));  // offset
  EXPECT_FALSE(SegmentMap::open(forge(bytes, second + 4, uint16_t{60000}), "x"));   // palette
  EXPECT_FALSE(SegmentMap::open(forge(bytes, second + 6, uint16_t{16}), "x"));      // bits
  EXPECT_FALSE(SegmentMap::open(forge(bytes, second + 6, uint16_t{5}), "x"));
  EXPECT_FALSE(SegmentMap::open(forge(bytes, tiles, uint32_t{300}), "x"));  // id of a uniform tile
  const size_t data = tiles + 64 * 8;
  EXPECT_FALSE(SegmentMap::open(forge(bytes, data, uint32_t{300}), "x"));       // id in a palette
  EXPECT_FALSE(SegmentMap::open(forge(bytes, 56, uint32_t{0x7FFFFFFF}), "x"));  // tile columns
  EXPECT_FALSE(SegmentMap::open(forge(bytes, 64, uint32_t{0}), "x"));           // segments
  EXPECT_FALSE(SegmentMap::open(forge(bytes, 32, double(NAN)), "x"));           // cell
  // A cell beyond the palette of two of its tile is open land, not the memory of another tile.
  const auto beyond = forge(bytes, data + 8, uint8_t{0xFF});
  const auto map = SegmentMap::open(beyond, "x");
  ASSERT_TRUE(map);
  EXPECT_EQ(map->id_of_cell(kTileSize, 0), 0U);
  EXPECT_EQ(map->id_of_cell(kTileSize + 1, 0), 0U);
}

/// Three tiles with few and long runs far from each other on a large map.
std::vector<std::byte> make_sparse_file(const Tile& tile) {
  SegmentMapWriter writer(kFrame, 4000, 3000);
  for (const auto& [column, row] : {std::pair(0, 0), {1999, 1500}, {3999, 2999}}) {
    writer.set_tile(column, row, tile);
  }
  writer.set_tile(100, 100, Tile{});  // open land is not stored
  auto bytes = writer.finish(segments(), "");
  EXPECT_TRUE(bytes);
  return bytes.value_or(std::vector<std::byte>());
}

Tile make_tile_of_runs() {
  Tile tile{};
  for (int row = 10; row < kTileSize; ++row) {
    for (int column = 0; column < kTileSize; ++column) {
      const int zone = row < 40 ? 12 : column + row;
      tile[static_cast<size_t>(row * kTileSize + column)] = zone > 80 ? 7 : column < 12 ? 3U : 9U;
    }
  }
  return tile;
}

TEST(SegmentMap, StoresOnlyWhatIsDrawn) {
  const Tile tile = make_tile_of_runs();
  const auto bytes = make_sparse_file(tile);
  EXPECT_LT(bytes.size(), 96 + 300 * 16 + 500 * 375 * 4 + 3 * (64 * 8 + 500));
  const auto map = SegmentMap::open(bytes, "x");
  ASSERT_TRUE(map) << map.error().message();
  for (int cell = 0; cell < kTileSize * kTileSize; ++cell) {
    const int column = cell % kTileSize, row = cell / kTileSize;
    const uint32_t id = tile[static_cast<size_t>(cell)];
    ASSERT_EQ(map->id_of_cell(1999 * kTileSize + column, 1500 * kTileSize + row), id);
    ASSERT_EQ(map->id_of_cell(3999 * kTileSize + column, 2999 * kTileSize + row), id);
    ASSERT_EQ(map->id_of_cell(2000 * kTileSize + column, 1500 * kTileSize + row), 0U);
    ASSERT_EQ(map->id_of_cell(100 * kTileSize + column, 100 * kTileSize + row), 0U);
  }
}

TEST(SegmentMap, SurvivesForgedBlocksAndRuns) {
  const auto bytes = make_sparse_file(make_tile_of_runs());
  const size_t blocks = 96 + 300 * 16, tiles = blocks + 500 * 375 * 4, data = tiles + 3 * 64 * 8;
  const size_t runs = data + 4 * 4;  // behind a palette of four
  EXPECT_FALSE(SegmentMap::open(forge(bytes, blocks, uint32_t{4}), "x"));       // block
  EXPECT_FALSE(SegmentMap::open(forge(bytes, 72, uint32_t{0x7FFFFFFF}), "x"));  // number of blocks
  EXPECT_FALSE(SegmentMap::open(forge(bytes, runs, uint64_t{2}), "x"));        // first row unmarked
  EXPECT_FALSE(SegmentMap::open(forge(bytes, runs + 8, uint16_t{999}), "x"));  // start of a row
  EXPECT_FALSE(SegmentMap::open(forge(bytes, runs, ~uint64_t{0}), "x"));       // more rows
  std::mt19937 random(5);
  for (int i = 0; i < 300; ++i) {  // whatever is opened can be read
    const auto forged =
        forge(bytes, tiles + random() % (bytes.size() - tiles - 1), static_cast<uint8_t>(random()));
    const auto map = SegmentMap::open(forged, "x");
    if (!map) continue;
    std::vector<uint32_t> ids(kTileSize);
    for (int row = 0; row < kTileSize; ++row) map->read_row(1999 * kTileSize, row, ids);
  }
}

TEST(SegmentMap, UnknownKindsAreOpenLand) {
  const auto bytes = forge(make_file(make_tiles()), 96 + 16 + 8, uint8_t{200});
  const auto map = SegmentMap::open(bytes, "x");
  ASSERT_TRUE(map);
  EXPECT_EQ(map->segment(1).kind, SegmentKind::kOpenLand);
}

TEST(SegmentMap, KeepsLayersAndLevels) {
  std::vector<Segment> written = segments();
  written[1].layer = -3;
  written[2] = {SegmentKind::kCarriageway, 5, 1, StreetLevels::kJoined};
  const SegmentMapWriter writer(kFrame, 1, 1);
  auto bytes = writer.finish(written, "");
  ASSERT_TRUE(bytes);
  EXPECT_EQ(SegmentMap::open(*bytes, "x")->segment(1), written[1]);
  EXPECT_EQ(SegmentMap::open(*bytes, "x")->segment(2), written[2]);
  *bytes = forge(*bytes, 96 + 2 * 16 + 10, uint8_t{3});
  EXPECT_EQ(SegmentMap::open(*bytes, "x")->segment(2).levels, StreetLevels::kOne);
}

TEST(SegmentMapWriter, RejectsInvalidTiles) {
  SegmentMapWriter unknown(kFrame, 1, 1);
  Tile tile{};
  tile[5] = 300;
  unknown.set_tile(0, 0, tile);
  EXPECT_FALSE(unknown.finish(segments(), ""));
}

}  // namespace
}  // namespace infuse::streetmap
