#include "drivers/camera/png_encoder.hpp"

#include <gtest/gtest.h>

#include "drivers/camera/image_decoder.hpp"

namespace infuse::camera {
namespace {

TEST(PngEncoder, DecodesBackExactly) {
  for (const PixelFormat format : {PixelFormat::kGrey8, PixelFormat::kBgr8}) {
    CameraFrame frame;
    frame.width = 37;
    frame.height = 21;
    frame.format = format;
    for (size_t i = 0; i < frame.row_bytes() * 21; ++i) {
      frame.pixels.push_back(static_cast<uint8_t>(i * i * 31 / 7));
    }
    const auto file = encode_png(frame);
    ASSERT_TRUE(file) << file.error().message();
    CameraFrame read;
    ASSERT_TRUE(decode_image(*file, {}, read));
    EXPECT_EQ(read.width, 37);
    EXPECT_EQ(read.format, format);
    EXPECT_EQ(read.pixels, frame.pixels);
  }
}

TEST(PngEncoder, RefusesUnsupportedImages) {
  CameraFrame frame;
  EXPECT_FALSE(encode_png(frame));
  frame.width = frame.height = 4;
  EXPECT_FALSE(encode_png(frame));  // pixels are missing
  frame.pixels.resize(16);
  EXPECT_TRUE(encode_png(frame));
  frame.format = PixelFormat::kBayerBggr8;
  EXPECT_FALSE(encode_png(frame));
}

}  // namespace
}  // namespace infuse::camera
