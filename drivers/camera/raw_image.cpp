#include "drivers/camera/raw_image.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "drivers/camera/image_decoder.hpp"

namespace infuse::camera {
namespace {

constexpr std::array kFormatNames = {"GREY", "YUYV", "UYVY", "RGB24", "BGR24",
                                     "RGGB", "BGGR", "GBRG", "GRBG",  "MJPEG"};

PixelFormat to_pixel_format(RawFormat format, bool grey) {
  switch (format) {
    case RawFormat::kYuyv:
    case RawFormat::kUyvy:
      return grey ? PixelFormat::kGrey8 : PixelFormat::kBgr8;
    case RawFormat::kRgb24:
    case RawFormat::kBgr24:
      return PixelFormat::kBgr8;
    case RawFormat::kBayerRggb:
      return PixelFormat::kBayerRggb8;
    case RawFormat::kBayerBggr:
      return PixelFormat::kBayerBggr8;
    case RawFormat::kBayerGbrg:
      return PixelFormat::kBayerGbrg8;
    case RawFormat::kBayerGrbg:
      return PixelFormat::kBayerGrbg8;
    case RawFormat::kGrey:
    case RawFormat::kMjpeg:
      break;
  }
  return PixelFormat::kGrey8;
}

uint8_t clamp_byte(int value) { return static_cast<uint8_t>(std::clamp(value, 0, 255)); }

// 8-bit fixed-point form of BT.601 in limited range: luma 16 ... 235.
void write_bgr(int luma, int u, int v, uint8_t* bgr) {
  const int c = 298 * (luma - 16) + 128;
  bgr[0] = clamp_byte((c + 516 * (u - 128)) >> 8);
  bgr[1] = clamp_byte((c - 100 * (u - 128) - 208 * (v - 128)) >> 8);
  bgr[2] = clamp_byte((c + 409 * (v - 128)) >> 8);
}

/// Unpacks a row of pixel pairs; `luma` is the index of the first luma in the four bytes of a pair,
/// colour has the other places.
void unpack_yuv_row(const uint8_t* row, size_t width, size_t luma, bool grey, uint8_t* out) {
  const size_t chroma = 1 - luma;
  if (grey) {
    for (size_t x = 0; x < width; ++x) out[x] = row[2 * x + luma];
    return;
  }
  for (size_t x = 0; x < width; ++x) {
    const uint8_t* pair = row + 4 * (x / 2);
    write_bgr(row[2 * x + luma], pair[chroma], pair[2 + chroma], out + 3 * x);
  }
}

void unpack_row(const RawImage& image, const uint8_t* row, bool grey, uint8_t* out) {
  const size_t width = static_cast<size_t>(image.width);
  switch (image.format) {
    case RawFormat::kYuyv:
      return unpack_yuv_row(row, width, 0, grey, out);
    case RawFormat::kUyvy:
      return unpack_yuv_row(row, width, 1, grey, out);
    case RawFormat::kRgb24:
      for (size_t x = 0; x < width; ++x) {
        out[3 * x] = row[3 * x + 2];
        out[3 * x + 1] = row[3 * x + 1];
        out[3 * x + 2] = row[3 * x];
      }
      return;
    default:
      std::memcpy(out, row, packed_row_bytes(image.format, image.width));
  }
}

}  // namespace

const char* name_of(RawFormat format) { return kFormatNames[static_cast<size_t>(format)]; }

std::optional<RawFormat> find_raw_format(std::string_view name) {
  const auto found = std::find(kFormatNames.begin(), kFormatNames.end(), name);
  if (found == kFormatNames.end()) return std::nullopt;
  return static_cast<RawFormat>(found - kFormatNames.begin());
}

size_t packed_row_bytes(RawFormat format, int width) {
  const size_t pixels = static_cast<size_t>(width);
  switch (format) {
    case RawFormat::kYuyv:
    case RawFormat::kUyvy:
      return (pixels + 1) / 2 * 4;
    case RawFormat::kRgb24:
    case RawFormat::kBgr24:
      return pixels * 3;
    case RawFormat::kMjpeg:
      return 0;
    default:
      return pixels;
  }
}

Result<void> unpack(const RawImage& image, bool grey, CameraFrame& frame) {
  if (image.format == RawFormat::kMjpeg) {
    return decode_image(image.bytes, {.grey = grey}, frame);
  }
  if (image.width <= 0 || image.height <= 0) return fail("the image has no pixels");
  const size_t row_bytes = packed_row_bytes(image.format, image.width);
  const size_t rows = static_cast<size_t>(image.height);
  if (image.row_bytes < row_bytes ||
      image.bytes.size() < (rows - 1) * image.row_bytes + row_bytes) {
    return fail("truncated image: " + std::to_string(image.bytes.size()) + " bytes");
  }
  frame.width = image.width;
  frame.height = image.height;
  frame.format = to_pixel_format(image.format, grey);
  frame.pixels.resize(rows * frame.row_bytes());
  for (size_t y = 0; y < rows; ++y) {
    unpack_row(image, image.bytes.data() + y * image.row_bytes, grey,
               frame.pixels.data() + y * frame.row_bytes());
  }
  return {};
}

}  // namespace infuse::camera
