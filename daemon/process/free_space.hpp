#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

namespace infuse::daemon {

/// Bytes that this user may still write to the disk of a folder, which need not exist yet; nothing
/// if it is not known.
inline std::optional<uint64_t> free_space(std::filesystem::path folder) {
  std::error_code failed;
  while (!std::filesystem::exists(folder, failed) && folder.has_relative_path()) {
    folder = folder.parent_path();
  }
  const auto space = std::filesystem::space(folder, failed);
  if (failed) return std::nullopt;
  return space.available;
}

}  // namespace infuse::daemon
