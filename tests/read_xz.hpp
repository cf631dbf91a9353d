#pragma once

#include <cstdio>
#include <filesystem>
#include <string>

namespace infuse {

/// Content of an xz file, by the program xz; empty if that fails.
inline std::string read_xz(const std::filesystem::path& file) {
  std::string text;
  FILE* pipe = popen(("xz -dc '" + file.string() + "'").c_str(), "r");
  if (pipe == nullptr) return text;
  char block[65536];
  for (size_t n; (n = std::fread(block, 1, sizeof block, pipe)) > 0;) text.append(block, n);
  return pclose(pipe) == 0 ? text : "";
}

}  // namespace infuse
