#include "daemon/mapping/geotiff_file.hpp"
#include "tests/daemon/mapping/cloud_of.hpp"

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <vector>

namespace infuse::daemon {
namespace {

template <class T>
T number_at(const std::string& bytes, size_t offset) {
  T value{};
  EXPECT_LE(offset + sizeof(T), bytes.size());
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

/// A file as a reader of TIFF 6.0 sees it.
struct Tiff {
  struct Entry {
    uint16_t type;
    uint32_t count;
    size_t at;  // of the values
  };
  std::string bytes;
  std::map<uint16_t, Entry> entries;
  std::vector<float> values;

  explicit Tiff(const std::string& file) : bytes(file) {
    EXPECT_EQ(bytes.substr(0, 2), "II");
    EXPECT_EQ(number_at<uint16_t>(bytes, 2), 42);
    size_t at = number_at<uint32_t>(bytes, 4);
    const auto count = number_at<uint16_t>(bytes, at);
    at += 2;
    uint16_t before = 0;
    for (int k = 0; k < count; ++k, at += 12) {
      const auto tag = number_at<uint16_t>(bytes, at);
      EXPECT_GT(tag, before);  // in ascending order
      before = tag;
      const auto type = number_at<uint16_t>(bytes, at + 2);
      const auto n = number_at<uint32_t>(bytes, at + 4);
      const size_t size = type == 12 ? 8 : type == 4 ? 4 : type == 3 ? 2 : 1;
      entries[tag] = {type, n, n * size > 4 ? number_at<uint32_t>(bytes, at + 8) : at + 8};
    }
    EXPECT_EQ(number_at<uint32_t>(bytes, at), 0U);
    read_strips();
  }

  double value(uint16_t tag, size_t k = 0) const {
    const Entry& e = entries.at(tag);
    EXPECT_LT(k, e.count);
    if (e.type == 12) return number_at<double>(bytes, e.at + 8 * k);
    return e.type == 3 ? number_at<uint16_t>(bytes, e.at + 2 * k)
                       : number_at<uint32_t>(bytes, e.at + 4 * k);
  }

  void read_strips() {
    const auto width = static_cast<size_t>(value(256)), height = static_cast<size_t>(value(257));
    const auto rows_per_strip = static_cast<size_t>(value(278));
    values.resize(width * height);
    for (size_t k = 0; k < entries.at(273).count; ++k) {
      const size_t first = k * rows_per_strip * width;
      uLongf size = std::min(rows_per_strip * width, values.size() - first) * sizeof(float);
      const auto stated = size;
      EXPECT_EQ(static_cast<size_t>(value(273, k)) % 2, 0U);
      const int code = uncompress(
          reinterpret_cast<Bytef*>(values.data() + first), &size,
          reinterpret_cast<const Bytef*>(bytes.data() + static_cast<size_t>(value(273, k))),
          static_cast<uLong>(value(279, k)));
      EXPECT_EQ(code, Z_OK);
      EXPECT_EQ(size, stated);
    }
  }
};

TEST(GeotiffFile, HasTheValuesAndTheirPlace) {
  MapImage image(0.5);
  image.add(cloud_of({{10.1F, 20.1F, 3, 0.25F}, {10.2F, 20.2F, 1, 0.75F}, {11.2F, 18.9F, -2, 1}}),
            Eigen::Isometry3d::Identity());
  for (const auto content : {MapImageContent::kHeight, MapImageContent::kIntensity}) {
    const auto raster = image.raster(content);
    ASSERT_TRUE(raster);
    const auto file = format_geotiff(*raster, std::nullopt);
    ASSERT_TRUE(file);
    const Tiff tiff(*file);
    ASSERT_EQ(tiff.value(256), 3);  // x from 10 to 11.5
    ASSERT_EQ(tiff.value(257), 4);  // y from 18.5 to 20.5
    EXPECT_EQ(tiff.value(258), 32);
    EXPECT_EQ(tiff.value(339), 3);
    EXPECT_EQ(tiff.value(33550, 0), 0.5);
    EXPECT_EQ(tiff.value(33550, 1), 0.5);
    EXPECT_EQ(tiff.value(33922, 3), 10);
    EXPECT_EQ(tiff.value(33922, 4), 20.5);
    const bool height = content == MapImageContent::kHeight;
    EXPECT_EQ(tiff.values[0], height ? 3.0F : 0.5F);
    EXPECT_EQ(tiff.values[11], height ? -2.0F : 1.0F);
    size_t empty = 0;
    for (const float value : tiff.values) empty += std::isnan(value) ? 1 : 0;
    EXPECT_EQ(empty, 10U);
    EXPECT_EQ(std::string(tiff.bytes.c_str() + tiff.entries.at(42113).at), "nan");
  }
}

// The central meridian of zone 32 is 9° E, where the easting is 500 km and the scale 0.9996.
TEST(GeotiffFile, IsInUtmWhereTheMapIsGeoreferenced) {
  const auto projection = MapProjection::create({.latitude = 49, .longitude = 9, .altitude = 110});
  ASSERT_TRUE(projection);
  const double north = projection->project({0, 0, 0}).y();
  MapImage image(1);
  image.add(cloud_of({{0.5F, 0, 0, 1}, {1000.5F, 0, 7, 1}}), Eigen::Isometry3d::Identity(),
            &*projection);
  const auto file = format_geotiff(*image.raster(MapImageContent::kHeight), *projection);
  ASSERT_TRUE(file);
  const Tiff tiff(*file);
  EXPECT_EQ(tiff.value(34735, 12), 3072);
  EXPECT_EQ(tiff.value(34735, 15), 32632);
  EXPECT_EQ(tiff.value(33922, 3), 500000);
  EXPECT_NEAR(tiff.value(33922, 4), north, 1);
  EXPECT_EQ(tiff.value(256), std::floor(0.9996 * 1000.5) + 1);
  std::vector<float> heights;
  for (const float value : tiff.values) {
    if (!std::isnan(value)) heights.push_back(value);
  }
  std::sort(heights.begin(), heights.end());
  ASSERT_EQ(heights.size(), 2U);
  EXPECT_NEAR(heights[0], 110, 1e-3);
  // The map's plane is a kilometre on 8 cm above the ellipsoid.
  EXPECT_NEAR(heights[1], 117 + 1e6 / 12.74e6, 2e-3);
  EXPECT_FALSE(MapProjection::create({.latitude = 85}));
}

TEST(GeotiffFile, KeepsLargeRastersInStrips) {
  MapImage image(0.2);
  mapping::Submap cloud;
  for (int i = 0; i < 3000; ++i) {
    const auto at = static_cast<float>(i);
    cloud.x.push_back(0.2F * at + 0.1F);
    cloud.y.push_back(0.1F * at);
    cloud.z.push_back(at);
    cloud.reflectivity.push_back(0.5F);
  }
  image.add(cloud, Eigen::Isometry3d::Identity());
  const auto raster = image.raster(MapImageContent::kHeight);
  ASSERT_TRUE(raster);
  const auto file = format_geotiff(*raster, std::nullopt);
  ASSERT_TRUE(file);
  const Tiff tiff(*file);
  EXPECT_GT(tiff.entries.at(273).count, 3U);
  ASSERT_EQ(tiff.values.size(), raster->values.size());
  EXPECT_EQ(
      std::memcmp(tiff.values.data(), raster->values.data(), raster->values.size() * sizeof(float)),
      0);
}

}  // namespace
}  // namespace infuse::daemon
