#include "drivers/camera/jpeg_decoder.hpp"

#include <turbojpeg.h>

#include <memory>

#include "drivers/camera/prepare_frame.hpp"

namespace infuse::camera {
namespace {

using Handle = std::unique_ptr<void, int (*)(tjhandle)>;

}  // namespace

Result<void> decode_jpeg(std::span<const uint8_t> file, const ImageOptions& options,
                         CameraFrame& frame) {
  thread_local Handle decoder(tjInitDecompress(), &tjDestroy);
  // After a warning the library's decoder refuses every following file, so it is replaced.
  const auto damaged = [] {
    const std::string why = tjGetErrorStr2(decoder.get());
    decoder.reset(tjInitDecompress());
    return fail("damaged JPEG file: " + why);
  };
  int width = 0;
  int height = 0;
  int subsampling = 0;
  int colour_space = 0;
  if (tjDecompressHeader3(decoder.get(), file.data(), file.size(), &width, &height, &subsampling,
                          &colour_space) != 0) {
    return damaged();
  }
  if (colour_space == TJCS_CMYK || colour_space == TJCS_YCCK) {
    return fail("JPEG file in CMYK colours", {}, "convert it to RGB or grey");
  }
  if (auto prepared = prepare_frame(width, height, colour_space != TJCS_GRAY, options, frame);
      !prepared) {
    return prepared;
  }
  const int format = frame.format == PixelFormat::kBgr8 ? TJPF_BGR : TJPF_GRAY;
  // TJFLAG_STOPONWARNING: otherwise the library fills the missing part of a truncated file with
  // grey and only warns.
  if (tjDecompress2(decoder.get(), file.data(), file.size(), frame.pixels.data(), width, 0, height,
                    format, TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS) != 0) {
    return damaged();
  }
  return {};
}

}  // namespace infuse::camera
