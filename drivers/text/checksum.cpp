#include "drivers/text/checksum.hpp"

#include <cstdint>

namespace infuse::text {

std::string checksum(std::string_view bytes) {
  uint64_t hash = 0xcbf29ce484222325;
  for (const char c : bytes) hash = (hash ^ static_cast<uint8_t>(c)) * 0x100000001b3;
  std::string text;
  constexpr int kDigits = 16;
  for (int digit = kDigits - 1; digit >= 0; --digit) {
    text += "0123456789abcdef"[(hash >> (4 * digit)) & 0xF];
  }
  return text;
}

}  // namespace infuse::text
