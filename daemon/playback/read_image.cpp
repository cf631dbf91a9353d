#include "daemon/playback/read_image.hpp"

#include <span>

#include "drivers/camera/colour.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::daemon {

Result<CameraFrame> read_image(const std::filesystem::path& path,
                               const camera::ImageOptions& options) {
  const auto text = text::read_text(path, kMaxImageBytes);
  if (!text) return tl::unexpected(text.error());
  const std::span bytes(reinterpret_cast<const uint8_t*>(text->data()), text->size());
  CameraFrame frame;
  if (auto decoded = camera::decode_image(bytes, options, frame); !decoded) {
    return fail(decoded.error().what, path.string(), decoded.error().hint);
  }
  return frame;
}

Result<CameraFrame> read_grey_image(const std::filesystem::path& path,
                                    const std::optional<PixelFormat>& mosaic) {
  auto frame = read_image(path, {.bayer = mosaic, .grey = !mosaic.has_value()});
  if (!frame || frame->format == PixelFormat::kGrey8) return frame;
  CameraFrame grey;
  camera::to_grey(*frame, grey);
  return grey;
}

Result<CameraFrame> read_scene_image(const std::filesystem::path& path,
                                     const camera::ImageOptions& options) {
  camera::ImageOptions without_bayer = options;
  without_bayer.bayer.reset();
  return read_image(path, without_bayer);
}

}  // namespace infuse::daemon
