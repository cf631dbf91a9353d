#pragma once

#include <string>
#include <string_view>

namespace infuse::text {

/// Returns the text without control characters, which could change a terminal: each byte of one is
/// replaced by ?. Those of UTF-8 (U+0080 to U+009F) too. `keep`: control characters that stay.
inline std::string printable(std::string_view text, std::string_view keep = "") {
  std::string clean(text);
  for (size_t i = 0; i < clean.size(); ++i) {
    const auto byte = static_cast<unsigned char>(clean[i]);
    const auto next = static_cast<unsigned char>(i + 1 < clean.size() ? clean[i + 1] : 0);
    const bool c1 = byte == 0xc2 && next >= 0x80 && next < 0xa0;
    if (!c1 && ((byte >= 0x20 && byte != 0x7f) || keep.find(clean[i]) != std::string_view::npos)) {
      continue;
    }
    clean[i] = '?';
    if (c1) clean[++i] = '?';
  }
  return clean;
}

/// Length of the longest name of a sensor, bytes: that of a host (HOST_NAME_MAX of Linux).
inline constexpr size_t kMaxNameBytes = 64;

/// True if the text can be the name of a sensor: short, not empty, without control characters.
inline bool is_name(std::string_view text) {
  return !text.empty() && text.size() <= kMaxNameBytes && printable(text) == text;
}

/// What `is_name` asks for, for messages.
inline constexpr const char* kNameRule = "a name has 1 to 64 bytes and no control characters";

}  // namespace infuse::text
