#pragma once

#include <filesystem>
#include <optional>

namespace infuse::recording {

/// Pixels across and down.
struct ImageSize {
  int width = 0;
  int height = 0;
  bool operator==(const ImageSize&) const = default;
};

/// The size of a PNG or JPEG file, from its head; nothing where it is neither.
std::optional<ImageSize> read_image_size(const std::filesystem::path& path);

}  // namespace infuse::recording
