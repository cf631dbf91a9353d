#include "drivers/camera/jpeg_encoder.hpp"

#include <turbojpeg.h>

#include <memory>

namespace infuse::camera {

Result<void> encode_jpeg(const CameraFrame& frame, int quality, std::vector<uint8_t>& file) {
  const bool colour = frame.format == PixelFormat::kBgr8;
  const size_t bytes = frame.row_bytes() * static_cast<size_t>(std::max(frame.height, 0));
  if (frame.width <= 0 || frame.height <= 0 || frame.pixels.size() < bytes) {
    return fail("an empty image");
  }
  using Compressor = std::unique_ptr<void, int (*)(tjhandle)>;
  thread_local const Compressor compressor(tjInitCompress(), &tjDestroy);
  const int subsampling = colour ? TJSAMP_420 : TJSAMP_GRAY;
  file.resize(tjBufSize(frame.width, frame.height, subsampling));
  unsigned char* out = file.data();
  unsigned long size = file.size();
  if (tjCompress2(compressor.get(), frame.pixels.data(), frame.width, 0, frame.height,
                  colour ? TJPF_BGR : TJPF_GRAY, &out, &size, subsampling, quality,
                  TJFLAG_NOREALLOC | TJFLAG_FASTDCT) != 0) {
    return fail(std::string("JPEG: ") + tjGetErrorStr2(compressor.get()));
  }
  file.resize(size);
  return {};
}

}  // namespace infuse::camera
