#pragma once

#include <filesystem>
#include <optional>

namespace infuse::importers {

/// Width and height of an image in pixels.
struct ImageSize {
  int width = 0;
  int height = 0;
  bool operator==(const ImageSize&) const = default;
};

/// Reads the size of a PNG or JPEG file from its header. Returns nothing for other files.
std::optional<ImageSize> read_image_size(const std::filesystem::path& path);

}  // namespace infuse::importers
