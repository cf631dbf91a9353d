#pragma once

#include <filesystem>
#include <optional>

namespace infuse::recording {

/// Pixels across and down.
struct PictureSize {
  int width = 0;
  int height = 0;
  bool operator==(const PictureSize&) const = default;
};

/// The size of a PNG or JPEG file, from its head; nothing where it is neither.
std::optional<PictureSize> picture_size(const std::filesystem::path& path);

}  // namespace infuse::recording
