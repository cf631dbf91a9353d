#include "drivers/camera/image_decoder.hpp"

#include <algorithm>
#include <array>

#include "drivers/camera/jpeg_decoder.hpp"
#include "drivers/camera/png_decoder.hpp"

namespace infuse::camera {

std::optional<std::string> ImageOptions::invalid() const {
  if (max_pixels <= 0) return "max_pixels must be positive";
  if (bayer && (*bayer == PixelFormat::kGrey8 || *bayer == PixelFormat::kBgr8)) {
    return "bayer must name a Bayer pattern";
  }
  return std::nullopt;
}

Result<void> decode_image(std::span<const uint8_t> file, const ImageOptions& options,
                          CameraFrame& frame) {
  constexpr std::array<uint8_t, 4> kPngMagic{0x89, 'P', 'N', 'G'};
  constexpr std::array<uint8_t, 3> kJpegMagic{0xFF, 0xD8, 0xFF};
  const auto begins_with = [&](const auto& magic) {
    return file.size() >= magic.size() && std::equal(magic.begin(), magic.end(), file.begin());
  };
  if (begins_with(kPngMagic)) return decode_png(file, options, frame);
  if (begins_with(kJpegMagic)) return decode_jpeg(file, options, frame);
  return fail("neither a PNG nor a JPEG file", {}, "unknown file signature");
}

}  // namespace infuse::camera
