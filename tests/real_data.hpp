#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

namespace infuse {

/// Where a real recording lies: `INFUSE_REAL_DATA` joined with `relative`; empty if that is not
/// set.
inline std::filesystem::path real_data(const std::filesystem::path& relative) {
  const char* root = std::getenv("INFUSE_REAL_DATA");
  return root == nullptr || *root == 0 ? std::filesystem::path()
                                       : std::filesystem::path(root) / relative;
}

}  // namespace infuse

/// Ends the test as skipped where INFUSE_REAL_DATA is not set, and as failed where the folder that
/// it names lacks the recording; declares `variable`, its path, otherwise.
#define INFUSE_REAL_DATA_OR_SKIP(variable, relative)                                \
  const std::filesystem::path variable = infuse::real_data(relative);               \
  if ((variable).empty()) GTEST_SKIP() << "no real recordings";                     \
  if (!std::filesystem::exists(variable)) {                                         \
    FAIL() << (variable) << " is missing: tests/DATA.md lists the recordings that " \
           << "INFUSE_REAL_DATA holds; leave it empty to skip tests on them";       \
  }
