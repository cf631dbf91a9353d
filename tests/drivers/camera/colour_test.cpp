#include "drivers/camera/colour.hpp"

#include <gtest/gtest.h>

namespace infuse::camera {
namespace {

/// A mosaic of one uniform colour.
CameraFrame uniform_mosaic(PixelFormat format, const char* tile, int width, int height) {
  CameraFrame frame;
  frame.width = width;
  frame.height = height;
  frame.format = format;
  for (int r = 0; r < height; ++r) {
    for (int c = 0; c < width; ++c) {
      const char colour = tile[(r % 2) * 2 + c % 2];
      frame.pixels.push_back(colour == 'B' ? 10 : colour == 'G' ? 100 : 200);
    }
  }
  return frame;
}

TEST(Colour, EveryBayerPatternGivesTheLuminanceOfAUniformColour) {
  const std::pair<PixelFormat, const char*> patterns[] = {{PixelFormat::kBayerRggb8, "RGGB"},
                                                          {PixelFormat::kBayerBggr8, "BGGR"},
                                                          {PixelFormat::kBayerGbrg8, "GBRG"},
                                                          {PixelFormat::kBayerGrbg8, "GRBG"}};
  for (const auto& [format, tile] : patterns) {
    CameraFrame grey;
    to_grey(uniform_mosaic(format, tile, 7, 5), grey);
    EXPECT_EQ(grey.pixels, std::vector<uint8_t>(7 * 5, luminance(10, 100, 200))) << tile;
  }
}

TEST(Colour, BilinearInterpolationIsExactOnARampAwayFromTheBorder) {
  CameraFrame ramp;
  ramp.width = ramp.height = 10;
  ramp.format = PixelFormat::kBayerRggb8;
  for (int r = 0; r < 10; ++r) {
    for (int c = 0; c < 10; ++c) ramp.pixels.push_back(static_cast<uint8_t>(10 * r + 4 * c));
  }
  CameraFrame grey;
  to_grey(ramp, grey);
  for (int r = 1; r < 9; ++r) {
    for (int c = 1; c < 9; ++c) {
      ASSERT_EQ(grey.pixels[static_cast<size_t>(r * 10 + c)], 10 * r + 4 * c);
    }
  }
}

TEST(Colour, GreyIsTheLuminanceAndKeepsTheStamp) {
  CameraFrame bgr;
  bgr.width = bgr.height = 1;
  bgr.format = PixelFormat::kBgr8;
  bgr.pixels = {10, 100, 200};
  bgr.stamp = Stamp::from_ns(42);
  bgr.sequence = 3;
  CameraFrame grey;
  to_grey(bgr, grey);
  EXPECT_EQ(grey.pixels, std::vector<uint8_t>{120});  // 1.14 + 58.7 + 59.8 = 119.64
  EXPECT_EQ(grey.stamp, bgr.stamp);
  EXPECT_EQ(grey.sequence, 3U);
}

}  // namespace
}  // namespace infuse::camera
