#include "drivers/camera/picture.hpp"

#include <algorithm>
#include <array>

#include "drivers/camera/jpeg_decoder.hpp"
#include "drivers/camera/png_decoder.hpp"

namespace infuse::camera {

std::optional<std::string> PictureOptions::invalid() const {
  if (max_pixels <= 0) return "max_pixels must be positive";
  if (bayer && (*bayer == PixelFormat::kGrey8 || *bayer == PixelFormat::kBgr8)) {
    return "bayer must name a Bayer pattern";
  }
  return std::nullopt;
}

Result<void> decode_picture(std::span<const uint8_t> file, const PictureOptions& options,
                            CameraFrame& frame) {
  constexpr std::array<uint8_t, 4> kPng{0x89, 'P', 'N', 'G'};
  constexpr std::array<uint8_t, 3> kJpeg{0xFF, 0xD8, 0xFF};
  const auto begins_with = [&](const auto& magic) {
    return file.size() >= magic.size() && std::equal(magic.begin(), magic.end(), file.begin());
  };
  if (begins_with(kPng)) return decode_png(file, options, frame);
  if (begins_with(kJpeg)) return decode_jpeg(file, options, frame);
  return fail("neither a PNG nor a JPEG file", {}, "its first bytes are those of no known format");
}

}  // namespace infuse::camera
