#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

namespace infuse {

/// Where a real recording lies: `INFUSE_REAL_DATA` joined with `relative`. It may not exist.
inline std::filesystem::path real_data(const std::filesystem::path& relative) {
  const char* root = std::getenv("INFUSE_REAL_DATA");
  return root == nullptr ? std::filesystem::path() : std::filesystem::path(root) / relative;
}

}  // namespace infuse

/// Ends the test as skipped where the real recording is absent; declares `path` otherwise.
#define INFUSE_REAL_DATA_OR_SKIP(path, relative)                      \
  const std::filesystem::path path = infuse::real_data(relative);     \
  if (path.empty() || !std::filesystem::exists(path)) {               \
    GTEST_SKIP() << "no " << (relative) << " under INFUSE_REAL_DATA"; \
  }
