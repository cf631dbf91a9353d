#include "drivers/camera/png_decoder.hpp"

#include <png.h>

#include <memory>

#include "drivers/camera/prepare_frame.hpp"

namespace infuse::camera {

Result<void> decode_png(std::span<const uint8_t> file, const ImageOptions& options,
                        CameraFrame& frame) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  const std::unique_ptr<png_image, void (*)(png_image*)> release(&image, &png_image_free);
  if (png_image_begin_read_from_memory(&image, file.data(), file.size()) == 0) {
    return fail(std::string("damaged PNG file: ") + image.message);
  }
  const bool colour = (image.format & PNG_FORMAT_FLAG_COLOR) != 0;
  if (auto prepared = prepare_frame(image.width, image.height, colour, options, frame); !prepared) {
    return prepared;
  }
  image.format = frame.format == PixelFormat::kBgr8 ? PNG_FORMAT_BGR : PNG_FORMAT_GRAY;
  const png_color black{0, 0, 0};
  if (png_image_finish_read(&image, &black, frame.pixels.data(),
                            static_cast<png_int_32>(frame.row_bytes()), nullptr) == 0) {
    return fail(std::string("damaged PNG file: ") + image.message);
  }
  return {};
}

}  // namespace infuse::camera
