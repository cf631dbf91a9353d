#pragma once

#include <filesystem>

#include "drivers/camera/image_decoder.hpp"

namespace infuse::daemon {

/// Maximum length of an image file.
inline constexpr size_t kMaxImageBytes = size_t{64} << 20;

/// Reads an image file of a drive. A Bayer mosaic is returned as grey values: they serve once they
/// are smoothed.
Result<CameraFrame> read_image(const std::filesystem::path& path,
                               const camera::ImageOptions& options);

}  // namespace infuse::daemon
