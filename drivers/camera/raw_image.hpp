#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::camera {

/// How a camera lays out a picture that it streams.
enum class RawFormat : uint8_t {
  kGrey,
  kYuyv,  ///< Y0 U Y1 V: two pixels share a colour
  kUyvy,  ///< U Y0 V Y1
  kRgb24,
  kBgr24,
  kBayerRggb,
  kBayerBggr,
  kBayerGbrg,
  kBayerGrbg,
  kMjpeg,  ///< each picture a JPEG file
};

/// "GREY", "YUYV", "UYVY", "RGB24", "BGR24", "RGGB", "BGGR", "GBRG", "GRBG", "MJPEG".
const char* name_of(RawFormat format);

/// The format of that name; nothing where there is none.
std::optional<RawFormat> find_raw_format(std::string_view name);

/// A picture as the driver hands it over.
struct RawImage {
  RawFormat format = RawFormat::kGrey;
  int width = 0;                   ///< pixels
  int height = 0;                  ///< pixels
  size_t row_bytes = 0;            ///< from a row to the next, padding included
  std::span<const uint8_t> bytes;  ///< of kMjpeg: the file
};

/// A picture that a camera streams.
struct StreamedImage {
  Stamp stamp;            ///< middle of the exposure, as far as the driver tells
  Duration exposure{0};   ///< how long it lasted; 0 where unknown
  double gain = 0;        ///< as the driver states it; 0 where unknown
  uint64_t sequence = 0;  ///< the driver's counter since the camera was opened
  RawImage raw;           ///< to be unpacked by whoever needs its pixels
};

/// Bytes of a row without padding; 0 for kMjpeg.
size_t packed_row_bytes(RawFormat format, int width);

/// Lays the picture out as a `CameraFrame`: sets width, height, format and pixels, and leaves the
/// rest. YUV becomes kGrey8 (its luma, as the camera gives it) where `grey` is requested, else
/// kBgr8 (ITU-R BT.601, limited range); MJPEG likewise; RGB becomes kBgr8; grey and Bayer stay. The
/// frame's memory is reused. Errors: fewer bytes than the picture has, a damaged JPEG.
Result<void> unpack(const RawImage& image, bool grey, CameraFrame& frame);

}  // namespace infuse::camera
