#include "fusion/streetmap/map_from_image.hpp"

#include <gtest/gtest.h>

#include <set>

#include "fusion/streetmap/segment_map.hpp"

namespace infuse::streetmap {
namespace {

CameraFrame grey(int width, int height, uint8_t value) {
  CameraFrame image;
  image.width = width;
  image.height = height;
  image.pixels.assign(static_cast<size_t>(width) * static_cast<size_t>(height), value);
  return image;
}

void fill(CameraFrame& image, int x0, int y0, int x1, int y1, uint8_t value) {
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) image.pixels[static_cast<size_t>(y * image.width + x)] = value;
  }
}

TEST(ImageMap, RegionsAndTheirOutlinesGetIds) {
  CameraFrame image = grey(120, 100, 240);
  fill(image, 0, 40, 120, 60, 150);  // a street from edge to edge
  fill(image, 20, 10, 50, 30, 100);  // a house north of it
  fill(image, 90, 80, 93, 83, 0);    // a speck
  const auto bytes = make_map_from_image(image, {.metres_per_pixel = 0.5}, "drawn");
  ASSERT_TRUE(bytes) << bytes.error().message();
  const auto map = SegmentMap::open(*bytes, "drawn");
  ASSERT_TRUE(map);
  EXPECT_FALSE(map->frame().georeferenced);
  // The centre of the image is the origin; up is north.
  const auto id = [&](int x, int y) { return map->id_at((x + 0.5 - 60) * 0.5, (49.5 - y) * 0.5); };
  const auto kind = [&](int x, int y) { return map->segment(id(x, y)).kind; };
  const std::set<uint32_t> regions{id(5, 5), id(60, 50), id(35, 20), id(5, 90)};
  EXPECT_EQ(regions.size(), 4U);
  for (const uint32_t region : regions) {
    EXPECT_EQ(map->segment(region).kind, SegmentKind::kImageRegion);
  }
  EXPECT_EQ(id(5, 5), id(110, 30));
  EXPECT_EQ(kind(60, 40), SegmentKind::kImageLine);
  EXPECT_EQ(kind(20, 20), SegmentKind::kImageLine);
  EXPECT_NE(id(60, 40), id(60, 59));  // two lines
  EXPECT_NE(id(60, 40), id(20, 20));
  EXPECT_EQ(kind(91, 81), SegmentKind::kImageLine);  // too small for a region
}

TEST(ImageMap, RejectsImagesWithoutAMap) {
  EXPECT_FALSE(make_map_from_image(grey(100, 100, 7), {}, ""));
  EXPECT_FALSE(make_map_from_image(grey(0, 0, 7), {}, ""));
  CameraFrame colour = grey(100, 100, 7);
  colour.format = PixelFormat::kBgr8;
  EXPECT_FALSE(make_map_from_image(colour, {}, ""));
  EXPECT_TRUE(ImageMapOptions{.metres_per_pixel = 0}.invalid());
  EXPECT_TRUE(ImageMapOptions{.edge_threshold = 0}.invalid());
  EXPECT_TRUE(ImageMapOptions{.min_region_pixels = 0}.invalid());
}

}  // namespace
}  // namespace infuse::streetmap
