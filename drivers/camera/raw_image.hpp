#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::camera {

/// Memory layout of an image that a camera streams.
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
  kMjpeg,  ///< each image a JPEG file
};

/// "GREY", "YUYV", "UYVY", "RGB24", "BGR24", "RGGB", "BGGR", "GBRG", "GRBG", "MJPEG".
const char* name_of(RawFormat format);

/// Returns the format of that name, or nothing.
std::optional<RawFormat> find_raw_format(std::string_view name);

/// An image as the driver delivers it.
struct RawImage {
  RawFormat format = RawFormat::kGrey;
  int width = 0;                   ///< pixels
  int height = 0;                  ///< pixels
  size_t row_bytes = 0;            ///< bytes from one row to the next, padding included
  std::span<const uint8_t> bytes;  ///< for kMjpeg: the file
};

/// An image that a camera streams, with its metadata.
struct StreamedImage {
  Stamp stamp;            ///< middle of the exposure, as far as the driver reports it
  Duration exposure{0};   ///< duration of the exposure; 0 if unknown
  double gain = 0;        ///< as the driver reports it; 0 if unknown
  uint64_t sequence = 0;  ///< frame counter of the driver since the camera was opened
  RawImage raw;           ///< not unpacked yet
};

/// Bytes of a row without padding; 0 for kMjpeg.
size_t packed_row_bytes(RawFormat format, int width);

/// Unpacks the image into a `CameraFrame`: sets width, height, format and pixels, and leaves the
/// other members. YUV becomes kGrey8 (its luma, unchanged) if `grey` is requested, else kBgr8
/// (ITU-R BT.601, limited range); MJPEG likewise; RGB becomes kBgr8; grey and Bayer are copied.
/// Reuses the frame's memory. Errors: fewer bytes than the image needs, a damaged JPEG.
Result<void> unpack(const RawImage& image, bool grey, CameraFrame& frame);

}  // namespace infuse::camera
