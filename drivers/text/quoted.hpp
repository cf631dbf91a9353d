#pragma once

#include <string>
#include <string_view>

#include "drivers/text/printable.hpp"

namespace infuse::text {

/// The beginning of a text from outside, at most 40 bytes, between single quotation marks: for
/// messages. Control characters are replaced.
inline std::string quoted(std::string_view text) {
  std::string quotation(1, '\'');
  quotation += printable(text.substr(0, 40));
  return quotation += '\'';
}

}  // namespace infuse::text
