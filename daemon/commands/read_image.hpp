#pragma once

#include <filesystem>

#include "drivers/camera/image_decoder.hpp"

namespace infuse::daemon {

/// Reads an image file of a drive. A Bayer mosaic is returned as grey values: they serve once they
/// are smoothed.
Result<CameraFrame> read_image(const std::filesystem::path& path,
                               const camera::ImageOptions& options);

}  // namespace infuse::daemon
