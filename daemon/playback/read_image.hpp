#pragma once

#include <filesystem>
#include <optional>

#include "drivers/camera/image_decoder.hpp"

namespace infuse::daemon {

/// Maximum length of an image file.
inline constexpr size_t kMaxImageBytes = size_t{64} << 20;

/// Reads and decodes an image file.
Result<CameraFrame> read_image(const std::filesystem::path& path,
                               const camera::ImageOptions& options);

/// The same as grey, kGrey8; a Bayer mosaic is interpolated.
Result<CameraFrame> read_grey_image(const std::filesystem::path& path,
                                    const std::optional<PixelFormat>& mosaic);

/// The same of a drive's camera, to be smoothed: the values of a Bayer mosaic are returned as grey.
Result<CameraFrame> read_scene_image(const std::filesystem::path& path,
                                     const camera::ImageOptions& options);

}  // namespace infuse::daemon
