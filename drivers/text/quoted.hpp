#pragma once

#include <string>
#include <string_view>

namespace infuse::text {

/// The beginning of a text from outside, at most 40 bytes, between single quotation marks: for
/// messages.
inline std::string quoted(std::string_view text) {
  std::string quotation(1, '\'');
  quotation += text.substr(0, 40);
  return quotation += '\'';
}

}  // namespace infuse::text
