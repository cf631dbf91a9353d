#pragma once

#include <string>

namespace infuse {

/// Beginning of a grey image of 64 × 48 pixels.
inline std::string make_png() {
  using namespace std::string_literals;
  return "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x40\0\0\0\x30\x08\0\0\0\0"s;
}

}  // namespace infuse
