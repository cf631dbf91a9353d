#include <cstdlib>

#include "drivers/camera/image_decoder.hpp"
#include "drivers/camera/raw_image.hpp"
#include "drivers/import/image_size.hpp"
#include "tests/fuzz/fuzz_file.hpp"

namespace {

// A frame has the pixels of its size.
void check(const infuse::CameraFrame& frame) {
  const size_t pixels = static_cast<size_t>(frame.width) * static_cast<size_t>(frame.height);
  if (frame.pixels.size() < pixels) std::abort();
}

}  // namespace

// Any bytes as an image file, as a file whose size is asked, and as an image of a camera.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace infuse;
  static fuzz::FuzzFile file(".png");
  const std::span<const uint8_t> bytes(data, size);
  CameraFrame frame;
  for (const bool grey : {false, true}) {
    const camera::ImageOptions options{.grey = grey, .max_pixels = 1'000'000};
    if (camera::decode_image(bytes, options, frame)) check(frame);
  }
  (void)importers::read_image_size(file.write(bytes));
  if (size < 4) return 0;
  const auto format =
      static_cast<camera::RawFormat>(data[0] % (static_cast<int>(camera::RawFormat::kMjpeg) + 1));
  const camera::RawImage raw{.format = format,
                             .width = data[1] % 32,
                             .height = data[2] % 32,
                             .row_bytes = data[3],
                             .bytes = bytes.subspan(4)};
  if (camera::unpack(raw, data[1] > 127, frame)) check(frame);
  return 0;
}
