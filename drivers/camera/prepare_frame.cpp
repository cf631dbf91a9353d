#include "drivers/camera/prepare_frame.hpp"

#include <string>

namespace infuse::camera {

Result<void> prepare_frame(int64_t width, int64_t height, bool colour, const ImageOptions& options,
                           CameraFrame& frame) {
  if (width <= 0 || height <= 0 || width > options.max_pixels / height) {
    return fail(
        "the image has " + std::to_string(width) + " x " + std::to_string(height) + " pixels", {},
        "at most " + std::to_string(options.max_pixels) + " pixels are accepted");
  }
  if (options.bayer && colour) {
    return fail("colour image instead of a Bayer mosaic", {}, "remove the Bayer pattern");
  }
  frame.width = static_cast<int>(width);
  frame.height = static_cast<int>(height);
  frame.format = options.bayer             ? *options.bayer
                 : colour && !options.grey ? PixelFormat::kBgr8
                                           : PixelFormat::kGrey8;
  frame.pixels.resize(frame.row_bytes() * static_cast<size_t>(height));
  return {};
}

}  // namespace infuse::camera
