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

/// Ends the test as skipped where the real recording is absent; declares `variable`, its path,
/// otherwise.
#define INFUSE_REAL_DATA_OR_SKIP(variable, relative)                  \
  const std::filesystem::path variable = infuse::real_data(relative); \
  if ((variable).empty() || !std::filesystem::exists(variable)) {     \
    GTEST_SKIP() << "no " << (relative) << " under INFUSE_REAL_DATA"; \
  }
