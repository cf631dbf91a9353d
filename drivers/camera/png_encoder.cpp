#include "drivers/camera/png_encoder.hpp"

#include <png.h>

namespace infuse::camera {

Result<std::vector<uint8_t>> encode_png(const CameraFrame& frame) {
  const bool colour = frame.format == PixelFormat::kBgr8;
  if (!colour && frame.format != PixelFormat::kGrey8)
    return fail("only grey and BGR images can be written as PNG");
  if (frame.width < 1 || frame.height < 1 ||
      frame.pixels.size() < frame.row_bytes() * static_cast<size_t>(frame.height)) {
    return fail("the image is empty");
  }
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(frame.width);
  image.height = static_cast<png_uint_32>(frame.height);
  image.format = colour ? PNG_FORMAT_BGR : PNG_FORMAT_GRAY;
  image.flags = PNG_IMAGE_FLAG_FAST;
  std::vector<uint8_t> file(PNG_IMAGE_PNG_SIZE_MAX(image));
  png_alloc_size_t size = file.size();
  if (png_image_write_to_memory(&image, file.data(), &size, 0, frame.pixels.data(), 0, nullptr) ==
      0) {
    return fail(std::string("libpng: ") + image.message);
  }
  file.resize(size);
  return file;
}

}  // namespace infuse::camera
