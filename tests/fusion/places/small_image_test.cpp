#include "fusion/places/small_image.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace infuse::places {
namespace {

CameraFrame grey_frame(int width, int height) {
  CameraFrame frame;
  frame.width = width;
  frame.height = height;
  frame.format = PixelFormat::kGrey8;
  for (int i = 0; i < width * height; ++i) frame.pixels.push_back(static_cast<uint8_t>(37 * i));
  return frame;
}

TEST(SmallImage, IsTheMeanOfWhatEachPixelCovers) {
  const CameraFrame frame = grey_frame(12, 6);
  const auto small = shrink_image(frame, 4, 3);
  ASSERT_EQ(small.size(), 12U);
  for (size_t row = 0; row < 3; ++row) {
    for (size_t column = 0; column < 4; ++column) {
      int sum = 0;
      for (size_t y = 2 * row; y < 2 * row + 2; ++y) {
        for (size_t x = 3 * column; x < 3 * column + 3; ++x) sum += frame.pixels[12 * y + x];
      }
      EXPECT_NEAR(small[4 * row + column], sum / 6.0, 0.51);
    }
  }
  EXPECT_EQ(shrink_image(frame, 12, 6), frame.pixels);
  // Sizes that do not divide cover every pixel once.
  CameraFrame even = frame;
  std::fill(even.pixels.begin(), even.pixels.end(), uint8_t{90});
  for (const uint8_t value : shrink_image(even, 7, 5)) EXPECT_EQ(value, 90);
  EXPECT_EQ(shrink_image(frame, 24, 6).size(), 144U);  // larger: repeated
}

}  // namespace
}  // namespace infuse::places
