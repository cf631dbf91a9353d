#pragma once

#include <cstdint>
#include <span>

#include "drivers/camera/image_decoder.hpp"

namespace infuse::camera {

/// Decodes the PNG files that cameras and data sets write: 8 bit, grey or colour, not interlaced,
/// without transparency or a colour profile. Three quarters and more of the time to decode such a
/// file is zlib's; libdeflate needs a third of it. Returns false, and leaves `frame` undefined, for
/// all other files and for damaged ones, which libpng then decodes or rejects.
bool decode_plain_png(std::span<const uint8_t> file, const ImageOptions& options,
                      CameraFrame& frame);

}  // namespace infuse::camera
