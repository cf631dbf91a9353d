#include "drivers/camera/plain_png.hpp"

#include <gtest/gtest.h>
#include <png.h>

#include <fstream>
#include <random>

#include "tests/real_data.hpp"

namespace infuse::camera {
namespace {

using Bytes = std::vector<uint8_t>;

struct PngOptions {
  int width = 53, height = 29;
  int colour = PNG_COLOR_TYPE_RGB;
  int bits = 8;
  int interlace = PNG_INTERLACE_NONE;
  int filter = PNG_ALL_FILTERS;
};

// A PNG file of smooth random samples, written by libpng.
Bytes make_png(const PngOptions& options) {
  Bytes file;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(
      png, &file,
      [](png_structp writer, png_bytep bytes, size_t count) {
        auto& out = *static_cast<Bytes*>(png_get_io_ptr(writer));
        out.insert(out.end(), bytes, bytes + count);
      },
      nullptr);
  png_set_IHDR(png, info, static_cast<png_uint_32>(options.width),
               static_cast<png_uint_32>(options.height), options.bits, options.colour,
               options.interlace, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, options.filter);
  png_write_info(png, info);
  std::mt19937 random(3);
  std::vector<Bytes> rows(static_cast<size_t>(options.height),
                          Bytes(static_cast<size_t>(options.width * 8)));
  uint8_t value = 100;
  std::vector<png_bytep> pointers;
  for (Bytes& row : rows) {
    for (uint8_t& sample : row)
      sample = value = static_cast<uint8_t>(value + static_cast<int>(random() % 31) - 15);
    pointers.push_back(row.data());
  }
  png_write_image(png, pointers.data());
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return file;
}

// The pixels as libpng decodes them.
Bytes decode_with_libpng(const Bytes& file, bool colour) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_memory(&image, file.data(), file.size()), 0);
  image.format = colour ? PNG_FORMAT_BGR : PNG_FORMAT_GRAY;
  Bytes pixels(PNG_IMAGE_SIZE(image));
  EXPECT_NE(png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr), 0);
  return pixels;
}

TEST(PlainPng, EveryFilterDecodesAsByLibpng) {
  for (const int filter : {PNG_FILTER_NONE, PNG_FILTER_SUB, PNG_FILTER_UP, PNG_FILTER_AVG,
                           PNG_FILTER_PAETH, PNG_ALL_FILTERS}) {
    for (const int colour : {PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_RGB}) {
      const Bytes file = make_png({.colour = colour, .filter = filter});
      CameraFrame frame;
      ASSERT_TRUE(decode_plain_png(file, {}, frame)) << filter;
      EXPECT_EQ(frame.width, 53);
      EXPECT_EQ(frame.height, 29);
      EXPECT_EQ(frame.pixels, decode_with_libpng(file, colour == PNG_COLOR_TYPE_RGB)) << filter;
    }
  }
}

TEST(PlainPng, OtherFilesAreLeftToLibpng) {
  CameraFrame frame;
  for (const PngOptions& options :
       {PngOptions{.colour = PNG_COLOR_TYPE_RGB_ALPHA}, PngOptions{.bits = 16},
        PngOptions{.colour = PNG_COLOR_TYPE_GRAY, .bits = 4},
        PngOptions{.interlace = PNG_INTERLACE_ADAM7}}) {
    const Bytes file = make_png(options);
    EXPECT_FALSE(decode_plain_png(file, {}, frame));
    EXPECT_TRUE(decode_image(file, {}, frame));
  }
  EXPECT_FALSE(decode_plain_png(make_png({}), {.grey = true}, frame));
  EXPECT_FALSE(decode_plain_png(make_png({}), {.max_pixels = 100}, frame));
}

TEST(PlainPng, DamagedFilesAreLeftToLibpng) {
  const Bytes file = make_png({});
  CameraFrame frame;
  for (size_t size = 0; size < file.size(); size += 7)
    EXPECT_FALSE(decode_plain_png(std::span(file).first(size), {}, frame)) << size;
  for (size_t at = 8; at < file.size(); at += 5) {
    Bytes damaged = file;
    damaged[at] ^= 0x10;
    EXPECT_FALSE(decode_plain_png(damaged, {}, frame)) << at;
  }
}

TEST(PlainPng, RealKittiImagesDecodeAsByLibpng) {
  INFUSE_REAL_DATA_OR_SKIP(folder, "calibration/kitti/image_2");
  std::ifstream stream(folder / "100000.png", std::ios::binary);
  const Bytes file{std::istreambuf_iterator<char>(stream), {}};
  CameraFrame frame;
  ASSERT_TRUE(decode_plain_png(file, {}, frame));
  EXPECT_EQ(frame.pixels, decode_with_libpng(file, true));
}

}  // namespace
}  // namespace infuse::camera
