#include "drivers/camera/raw_image.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <vector>

#include "drivers/camera/v4l2_source.hpp"

namespace infuse::camera {
namespace {

/// Definition of BT.601, limited range, in real numbers.
std::array<double, 3> expected_bgr(double y, double u, double v) {
  const double luma = 255.0 / 219.0 * (y - 16);
  const double blue = 255.0 / 224.0 * (u - 128), red = 255.0 / 224.0 * (v - 128);
  return {luma + 1.772 * blue, luma - 0.344136 * blue - 0.714136 * red, luma + 1.402 * red};
}

RawImage make_raw_image(RawFormat format, int width, int height, size_t row_bytes,
                        const std::vector<uint8_t>& bytes) {
  return {format, width, height, row_bytes, bytes};
}

TEST(RawImage, YuvInGreyIsItsLuma) {
  const std::vector<uint8_t> yuyv = {10, 1, 20, 2, 30, 3, 40, 4};
  const std::vector<uint8_t> uyvy = {1, 10, 2, 20, 3, 30, 4, 40};
  CameraFrame frame;
  ASSERT_TRUE(unpack(make_raw_image(RawFormat::kYuyv, 2, 2, 4, yuyv), true, frame));
  EXPECT_EQ(frame.pixels, (std::vector<uint8_t>{10, 20, 30, 40}));
  EXPECT_EQ(frame.format, PixelFormat::kGrey8);
  ASSERT_TRUE(unpack(make_raw_image(RawFormat::kUyvy, 4, 1, 8, uyvy), true, frame));
  EXPECT_EQ(frame.pixels, (std::vector<uint8_t>{10, 20, 30, 40}));
  EXPECT_EQ(frame.width, 4);
}

TEST(RawImage, YuvInColourFollowsBt601) {
  for (int y = 16; y <= 235; y += 31) {
    for (int u = 16; u <= 240; u += 32) {
      for (int v = 16; v <= 240; v += 32) {
        const auto byte = [](int value) { return static_cast<uint8_t>(value); };
        const std::vector<uint8_t> yuyv = {byte(y), byte(u), byte(y), byte(v)};
        const std::vector<uint8_t> uyvy = {byte(u), byte(y), byte(v), byte(y)};
        CameraFrame first, second;
        ASSERT_TRUE(unpack(make_raw_image(RawFormat::kYuyv, 2, 1, 4, yuyv), false, first));
        ASSERT_TRUE(unpack(make_raw_image(RawFormat::kUyvy, 2, 1, 4, uyvy), false, second));
        EXPECT_EQ(first.pixels, second.pixels);
        const auto truth = expected_bgr(y, u, v);
        for (size_t c = 0; c < 3; ++c) {
          const double expected = std::clamp(truth[c], 0.0, 255.0);
          EXPECT_NEAR(first.pixels[c], expected, 1.5);
          EXPECT_EQ(first.pixels[c], first.pixels[3 + c]);
        }
      }
    }
  }
}

TEST(RawImage, AnOddWidthUsesHalfOfTheLastPair) {
  const std::vector<uint8_t> yuyv = {10, 128, 20, 128, 30, 128, 99, 128};
  CameraFrame frame;
  ASSERT_TRUE(unpack(make_raw_image(RawFormat::kYuyv, 3, 1, 8, yuyv), true, frame));
  EXPECT_EQ(frame.pixels, (std::vector<uint8_t>{10, 20, 30}));
}

TEST(RawImage, RgbBecomesBgrWithoutPadding) {
  const std::vector<uint8_t> rgb = {1, 2, 3, 4, 5, 6, 0, 0, 7, 8, 9, 10, 11, 12};
  CameraFrame frame;
  ASSERT_TRUE(unpack(make_raw_image(RawFormat::kRgb24, 2, 2, 8, rgb), true, frame));
  EXPECT_EQ(frame.format, PixelFormat::kBgr8);
  EXPECT_EQ(frame.pixels, (std::vector<uint8_t>{3, 2, 1, 6, 5, 4, 9, 8, 7, 12, 11, 10}));
  ASSERT_TRUE(unpack(make_raw_image(RawFormat::kBgr24, 2, 2, 8, rgb), true, frame));
  EXPECT_EQ(frame.pixels, (std::vector<uint8_t>{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}));
}

TEST(RawImage, BayerAndGreyAreUnchanged) {
  const std::vector<uint8_t> bytes = {1, 2, 3, 4};
  const std::pair<RawFormat, PixelFormat> formats[] = {
      {RawFormat::kGrey, PixelFormat::kGrey8},
      {RawFormat::kBayerRggb, PixelFormat::kBayerRggb8},
      {RawFormat::kBayerBggr, PixelFormat::kBayerBggr8},
      {RawFormat::kBayerGbrg, PixelFormat::kBayerGbrg8},
      {RawFormat::kBayerGrbg, PixelFormat::kBayerGrbg8}};
  for (const auto& [raw, format] : formats) {
    CameraFrame frame;
    ASSERT_TRUE(unpack(make_raw_image(raw, 2, 2, 2, bytes), false, frame));
    EXPECT_EQ(frame.format, format);
    EXPECT_EQ(frame.pixels, bytes);
    EXPECT_EQ(find_raw_format(name_of(raw)), raw);
  }
  EXPECT_FALSE(find_raw_format("H264"));
}

TEST(RawImage, RefusesTruncatedImages) {
  CameraFrame frame;
  const std::vector<uint8_t> bytes(11);
  EXPECT_FALSE(unpack(make_raw_image(RawFormat::kRgb24, 2, 2, 6, bytes), true, frame));
  EXPECT_TRUE(unpack(make_raw_image(RawFormat::kGrey, 5, 2, 6, bytes), true, frame));
  EXPECT_FALSE(unpack(make_raw_image(RawFormat::kGrey, 6, 2, 5, bytes), true, frame));
  EXPECT_FALSE(unpack(make_raw_image(RawFormat::kGrey, 0, 2, 5, bytes), true, frame));
  EXPECT_FALSE(unpack(make_raw_image(RawFormat::kMjpeg, 2, 2, 0, bytes), true, frame));
}

TEST(V4l2Options, RejectInvalidValues) {
  EXPECT_FALSE(V4l2Options{}.invalid());
  EXPECT_TRUE(V4l2Options{.device = "video0"}.invalid());
  EXPECT_TRUE((V4l2Options{.width = 640}.invalid()));
  EXPECT_TRUE((V4l2Options{.rate_hz = -1}.invalid()));
  EXPECT_TRUE((V4l2Options{.exposure = Duration(0)}.invalid()));
}

TEST(V4l2Source, OpenFailsWithoutACamera) {
  const host::TimeBase base;
  const auto missing = V4l2Source::open({.device = "/dev/no-such-video"}, base);
  ASSERT_FALSE(missing.has_value());
  EXPECT_EQ(missing.error().where, "/dev/no-such-video");
  EXPECT_FALSE(V4l2Source::open({.device = "/dev/null"}, base).has_value());
}

}  // namespace
}  // namespace infuse::camera
