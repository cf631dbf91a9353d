#include "daemon/record/image_file.hpp"

#include "drivers/camera/png_encoder.hpp"

namespace infuse::daemon {
namespace {

bool is_bayer(PixelFormat format) {
  return format != PixelFormat::kGrey8 && format != PixelFormat::kBgr8;
}

}  // namespace

Result<ImageFile> encode_image_file(const camera::RawImage& raw) {
  ImageFile file;
  if (raw.format == camera::RawFormat::kMjpeg) {
    file.bytes.assign(raw.bytes.begin(), raw.bytes.end());
    file.extension = ".jpg";
    file.grey = true;
    return file;
  }
  CameraFrame frame;
  if (const auto unpacked = camera::unpack(raw, true, frame); !unpacked) {
    return tl::unexpected(unpacked.error());
  }
  if (is_bayer(frame.format)) {
    file.mosaic = frame.format;
    frame.format = PixelFormat::kGrey8;
  }
  return camera::encode_png(frame).map([&](std::vector<uint8_t> bytes) {
    file.bytes = std::move(bytes);
    return std::move(file);
  });
}

}  // namespace infuse::daemon
