#pragma once

#include <algorithm>
#include <filesystem>

namespace infuse::recording {

/// True if a file or folder lies in `folder`, links followed: a link in a drive from elsewhere does
/// not lead to files of this host.
inline bool lies_inside(const std::filesystem::path& folder, const std::filesystem::path& path) {
  std::error_code failed;
  const auto outer = std::filesystem::canonical(folder, failed);
  if (failed) return false;
  const auto inner = std::filesystem::canonical(path, failed);
  if (failed) return false;
  const auto [rest, unused] = std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end());
  return rest == outer.end();
}

}  // namespace infuse::recording
