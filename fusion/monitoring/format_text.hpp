#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace infuse::monitoring {

/// Formats as printf does; at most 199 bytes.
template <class... Values>
std::string format_text(const char* format, Values... values) {
  std::array<char, 200> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

}  // namespace infuse::monitoring
