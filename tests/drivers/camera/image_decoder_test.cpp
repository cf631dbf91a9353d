#include "drivers/camera/image_decoder.hpp"

#include <gtest/gtest.h>
#include <png.h>

#include <fstream>
#include <random>

#include "tests/drivers/camera/jpeg_file.hpp"
#include "tests/real_data.hpp"

namespace infuse::camera {
namespace {

using testing::make_jpeg;
using Bytes = std::vector<uint8_t>;

/// A PNG file of the given libpng format, every sample from a seeded generator.
Bytes make_png(unsigned width, unsigned height, png_uint_32 format, Bytes& samples) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = width;
  image.height = height;
  image.format = format;
  samples.resize(PNG_IMAGE_SIZE(image));
  std::mt19937 random(7);
  for (uint8_t& s : samples) s = static_cast<uint8_t>(random());
  png_alloc_size_t size = 0;
  EXPECT_NE(0, png_image_write_get_memory_size(image, size, 0, samples.data(), 0, nullptr));
  Bytes file(size);
  EXPECT_NE(0,
            png_image_write_to_memory(&image, file.data(), &size, 0, samples.data(), 0, nullptr));
  file.resize(size);
  return file;
}

TEST(DecodeImage, DecodesGreyAndColourPngExactly) {
  CameraFrame frame;
  Bytes samples;
  Bytes file = make_png(31, 17, PNG_FORMAT_GRAY, samples);
  ASSERT_TRUE(decode_image(file, {}, frame));
  EXPECT_EQ(frame.format, PixelFormat::kGrey8);
  EXPECT_EQ(frame.width, 31);
  EXPECT_EQ(frame.height, 17);
  EXPECT_EQ(frame.pixels, samples);

  file = make_png(8, 5, PNG_FORMAT_BGR, samples);
  ASSERT_TRUE(decode_image(file, {}, frame));
  EXPECT_EQ(frame.format, PixelFormat::kBgr8);
  EXPECT_EQ(frame.pixels, samples);
}

TEST(DecodeImage, ReadsABayerMosaicUnchangedAndRefusesColour) {
  CameraFrame frame;
  Bytes samples;
  const ImageOptions options{.bayer = PixelFormat::kBayerGrbg8};
  ASSERT_TRUE(decode_image(make_png(6, 4, PNG_FORMAT_GRAY, samples), options, frame));
  EXPECT_EQ(frame.format, PixelFormat::kBayerGrbg8);
  EXPECT_EQ(frame.pixels, samples);
  const auto refused = decode_image(make_png(6, 4, PNG_FORMAT_RGB, samples), options, frame);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().what.find("Bayer"), std::string::npos);
}

TEST(DecodeImage, DecodesJpegWithinItsLossInColourAndGrey) {
  CameraFrame frame;
  const Bytes file = make_jpeg(100, 60, TJSAMP_444);
  ASSERT_TRUE(decode_image(file, {}, frame));
  ASSERT_EQ(frame.format, PixelFormat::kBgr8);
  for (int r = 0; r < 60; ++r) {
    for (int c = 0; c < 100; ++c) {
      const size_t at = static_cast<size_t>(r * 100 + c) * 3;
      ASSERT_NEAR(frame.pixels[at], 2 * c, 6);
      ASSERT_NEAR(frame.pixels[at + 1], 2 * r, 6);
      ASSERT_NEAR(frame.pixels[at + 2], 90, 6);
    }
  }
  ASSERT_TRUE(decode_image(file, {.grey = true}, frame));
  EXPECT_EQ(frame.format, PixelFormat::kGrey8);
  EXPECT_NEAR(frame.pixels[30 * 100 + 50], 0.114 * 100 + 0.587 * 60 + 0.299 * 90, 4);
}

TEST(DecodeImage, DecodesIntactFilesAfterADamagedOne) {
  CameraFrame frame;
  const Bytes file = make_jpeg(100, 60, TJSAMP_444);
  const Bytes cut(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(file.size() * 3 / 4));
  for (int i = 0; i < 3; ++i) {
    EXPECT_FALSE(decode_image(cut, {}, frame));
    EXPECT_TRUE(decode_image(file, {}, frame));
  }
}

TEST(DecodeImage, ReusesMemoryForAStreamOfOneSize) {
  CameraFrame frame;
  Bytes samples;
  const Bytes file = make_png(64, 64, PNG_FORMAT_GRAY, samples);
  ASSERT_TRUE(decode_image(file, {}, frame));
  const uint8_t* memory = frame.pixels.data();
  ASSERT_TRUE(decode_image(file, {}, frame));
  EXPECT_EQ(frame.pixels.data(), memory);
}

TEST(DecodeImage, ErrorsNameTheirCause) {
  CameraFrame frame;
  EXPECT_FALSE(decode_image(Bytes{}, {}, frame));
  EXPECT_EQ(decode_image(Bytes{'G', 'I', 'F', '8'}, {}, frame).error().what,
            "neither a PNG nor a JPEG file");
  Bytes samples;
  const auto large =
      decode_image(make_png(100, 100, PNG_FORMAT_GRAY, samples), {.max_pixels = 9999}, frame);
  ASSERT_FALSE(large);
  EXPECT_EQ(large.error().what, "the image has 100 x 100 pixels");
  EXPECT_TRUE(ImageOptions{.max_pixels = 0}.invalid());
  EXPECT_TRUE(ImageOptions{.bayer = PixelFormat::kBgr8}.invalid());
}

TEST(DecodeImage, ReportsTruncatedFilesAsErrors) {
  CameraFrame frame;
  Bytes samples;
  for (const Bytes& file :
       {make_png(9, 9, PNG_FORMAT_BGR, samples), make_jpeg(16, 16, TJSAMP_420)}) {
    // The last bytes of a PNG (its IEND chunk) and of a JPEG (its EOI marker) contain no pixels.
    for (size_t length = 0; length + 16 < file.size(); ++length) {
      EXPECT_FALSE(decode_image(std::span(file).first(length), {}, frame)) << length;
    }
  }
}

TEST(DecodeImage, ReportsMutatedFilesAsErrorsAtMost) {
  CameraFrame frame;
  Bytes samples;
  std::mt19937 random(11);
  int failed = 0;
  for (const Bytes& whole :
       {make_png(40, 30, PNG_FORMAT_BGR, samples), make_jpeg(40, 30, TJSAMP_420)}) {
    for (int i = 0; i < 2000; ++i) {
      Bytes file = whole;
      for (int k = 0; k < 4; ++k) file[random() % file.size()] = static_cast<uint8_t>(random());
      if (!decode_image(file, {.max_pixels = 1'000'000}, frame)) ++failed;
    }
  }
  EXPECT_GT(failed, 2000);
}

TEST(DecodeImage, DecodesARealKittiImage) {
  INFUSE_REAL_DATA_OR_SKIP(path, "calibration/kitti/image_2/000001.png");
  std::ifstream in(path, std::ios::binary);
  const Bytes file((std::istreambuf_iterator<char>(in)), {});
  CameraFrame frame;
  ASSERT_TRUE(decode_image(file, {}, frame));
  EXPECT_EQ(frame.width, 1242);
  EXPECT_EQ(frame.height, 375);
  EXPECT_EQ(frame.format, PixelFormat::kBgr8);
}

}  // namespace
}  // namespace infuse::camera
