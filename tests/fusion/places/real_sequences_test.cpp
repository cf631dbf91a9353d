// Real images of the same way in two seasons (Nordland) and by two walkers (Gardens Point).

#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <random>

#include "drivers/camera/image_decoder.hpp"
#include "fusion/places/image_descriptor.hpp"
#include "fusion/places/match_evidence.hpp"
#include "fusion/places/sequence_match.hpp"
#include "tests/real_data.hpp"

namespace infuse::places {
namespace {

using Describe = ImageDescriptor (*)(std::span<const uint8_t>, int, int);

ImageDescriptor by_edges(std::span<const uint8_t> pixels, int width, int height) {
  return describe_image(pixels, width, height);
}

ImageDescriptor by_contrast(std::span<const uint8_t> pixels, int width, int height) {
  return describe_contrast(pixels, width, height);
}

/// Descriptors of the tiles `begin` … `end` - 1 of a mosaic, row by row.
std::vector<ImageDescriptor> describe_tiles(const std::filesystem::path& file, int columns,
                                            int width, int height, int begin, int end,
                                            Describe describe = by_edges) {
  std::ifstream in(file, std::ios::binary);
  const std::vector<char> bytes(std::istreambuf_iterator<char>(in), {});
  CameraFrame mosaic;
  const auto decoded = camera::decode_image(
      {reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()}, {.grey = true}, mosaic);
  EXPECT_TRUE(decoded);
  std::vector<ImageDescriptor> out;
  if (!decoded) return out;
  std::vector<uint8_t> tile(static_cast<size_t>(width * height));
  for (int k = begin; k < end; ++k) {
    const int left = k % columns * width, top = k / columns * height;
    for (int row = 0; row < height; ++row) {
      for (int column = 0; column < width; ++column) {
        tile[static_cast<size_t>(row * width + column)] =
            mosaic.pixels[static_cast<size_t>((top + row) * mosaic.width + left + column)];
      }
    }
    out.push_back(describe(tile, width, height));
  }
  remove_common_view(out);
  return out;
}

struct Drives {
  std::vector<ImageDescriptor> query, map;
};

/// The chances that are stated of queries, and what is true.
struct Stated {
  std::vector<double> chance;
  std::vector<bool> right;  ///< within ten places of the truth

  void add(const Stated& other) {
    chance.insert(chance.end(), other.chance.begin(), other.chance.end());
    right.insert(right.end(), other.right.begin(), other.right.end());
  }
  double found() const {
    const auto is_found = [](double c) { return c <= 0.02; };
    return static_cast<double>(std::count_if(chance.begin(), chance.end(), is_found)) / count();
  }
  double wrong() const {
    double sum = 0;
    for (size_t i = 0; i < chance.size(); ++i) sum += chance[i] <= 0.02 && !right[i] ? 1 : 0;
    return sum / count();
  }
  /// Expected calibration error over ten bins (Guo and others 2017).
  double calibration_error() const {
    std::array<double, 10> difference{};
    for (size_t i = 0; i < chance.size(); ++i) {
      const auto bin = std::min<size_t>(9, static_cast<size_t>(10 * chance[i]));
      difference[bin] += chance[i] - (right[i] ? 0 : 1);
    }
    double sum = 0;
    for (const double value : difference) sum += std::abs(value);
    return sum / count();
  }

 private:
  double count() const { return static_cast<double>(chance.size()); }
};

/// Of the queries among the places from `first_place` to before `end_place`.
Stated stated_of(const Drives& drives, size_t first_place, size_t end_place, size_t length) {
  SimilarityTable table{drives.query.size(), end_place - first_place, {}};
  for (const ImageDescriptor& query : drives.query) {
    for (size_t j = first_place; j < end_place; ++j)
      table.values.push_back(static_cast<float>(similarity(query, drives.map[j])));
  }
  const auto matches = match_sequences(table, {.length = length});
  Stated out{MatchEvidence(table, {.length = length}).chances(matches), {}};
  for (size_t i = 0; i < matches.size(); ++i) {
    const size_t place = matches[i].place + first_place;
    out.right.push_back(place <= i + 10 && i <= place + 10);
  }
  return out;
}

/// On the whole map, and on each half of it: then half of the queries are elsewhere.
Stated stated_of_all(const Drives& drives, size_t length) {
  const size_t count = drives.map.size();
  Stated out = stated_of(drives, 0, count, length);
  out.add(stated_of(drives, 0, count / 2, length));
  out.add(stated_of(drives, count / 2, count, length));
  return out;
}

/// Share of the queries that are found within two places of the truth. `kept` are the numbers of
/// the queries in the map's numbering.
double share_right(const Drives& drives, const std::vector<size_t>& kept, size_t length) {
  SimilarityTable table{kept.size(), drives.map.size(), {}};
  for (const size_t query : kept) {
    for (const ImageDescriptor& place : drives.map) {
      table.values.push_back(static_cast<float>(similarity(drives.query[query], place)));
    }
  }
  const auto matches = match_sequences(table, {.length = length});
  size_t right = 0;
  for (size_t i = 0; i < kept.size(); ++i) {
    right += matches[i].place + 2 >= kept[i] && matches[i].place <= kept[i] + 2 ? 1U : 0U;
  }
  return static_cast<double>(right) / static_cast<double>(kept.size());
}

std::vector<size_t> all_of(size_t count) {
  std::vector<size_t> out(count);
  for (size_t i = 0; i < count; ++i) out[i] = i;
  return out;
}

/// Without every third, at random.
std::vector<size_t> thinned(size_t count) {
  std::mt19937 random(1);
  std::vector<size_t> out;
  for (size_t i = 0; i < count; ++i) {
    if (random() % 3 != 0) out.push_back(i);
  }
  return out;
}

Drives nordland(const std::filesystem::path& folder, int begin, int end,
                Describe describe = by_edges) {
  return {
      describe_tiles(folder / "winter_1200-2199_grid40x25.png", 40, 64, 32, begin, end, describe),
      describe_tiles(folder / "summer_1200-2199_grid40x25.png", 40, 64, 32, begin, end, describe)};
}

void report(const char* name, const Drives& drives, size_t length) {
  const size_t count = drives.query.size();
  std::cout << name << ": single " << share_right(drives, all_of(count), 1) << ", sequences of "
            << length << " " << share_right(drives, all_of(count), length) << ", thinned "
            << share_right(drives, thinned(count), length);
  const Stated whole = stated_of(drives, 0, count, length);
  const Stated half = stated_of(drives, 0, count / 2, length);
  std::cout << "; found " << whole.found() << ", wrong " << whole.wrong()
            << "; on half the map found " << half.found() << ", wrong " << half.wrong()
            << "; calibration error " << stated_of_all(drives, length).calibration_error() << "\n";
}

TEST(RealSequences, ARailwayInWinterIsFoundOnTheMapOfSummer) {
  INFUSE_REAL_DATA_OR_SKIP(folder, "places/nordland_64x32");
  report("chosen on 0 to 499", nordland(folder, 0, 500), 21);
  const Drives drives = nordland(folder, 500, 1000);
  ASSERT_EQ(drives.query.size(), 500U);
  report("500 to 999", drives, 21);
  EXPECT_GE(share_right(drives, all_of(500), 21), 0.94);
  EXPECT_GE(share_right(drives, thinned(500), 21), 0.93);
  const Stated whole = stated_of(drives, 0, 500, 21), half = stated_of(drives, 0, 250, 21);
  EXPECT_GT(whole.found(), 0.8);
  EXPECT_LT(whole.wrong(), 0.02);
  EXPECT_LT(half.wrong(), 0.02);
  report("500 to 999", drives, 9);
  for (const size_t length : {9U, 21U})
    EXPECT_LT(stated_of_all(drives, length).calibration_error(), 0.05);
}

TEST(RealSequences, EdgesFindMoreThanACorrelationOfLocalContrast) {
  INFUSE_REAL_DATA_OR_SKIP(folder, "places/nordland_64x32");
  const Drives edges = nordland(folder, 500, 1000);
  const Drives contrast = nordland(folder, 500, 1000, by_contrast);
  ASSERT_EQ(contrast.query.size(), 500U);
  const auto lead = [&](size_t length) {
    const double by_edges = share_right(edges, all_of(500), length);
    const double by_contrast = share_right(contrast, all_of(500), length);
    std::cout << "sequences of " << length << ": edges " << by_edges << ", contrast " << by_contrast
              << "\n";
    return by_edges - by_contrast;
  };
  EXPECT_GE(lead(21), 0.02);
  EXPECT_GE(lead(9), 0.05);
  EXPECT_GE(lead(1), 0.10);
}

TEST(RealSequences, AWalkIsFoundOnAnother) {
  INFUSE_REAL_DATA_OR_SKIP(folder, "places/gardens_point_thumbs");
  const Drives drives{describe_tiles(folder / "query_200_grid20x10.png", 20, 99, 56, 0, 200),
                      describe_tiles(folder / "truth_200_grid20x10.png", 20, 99, 56, 0, 200)};
  ASSERT_EQ(drives.query.size(), 200U);
  report("Gardens Point", drives, 9);
  EXPECT_GE(share_right(drives, all_of(200), 9), 0.88);
}

}  // namespace
}  // namespace infuse::places
