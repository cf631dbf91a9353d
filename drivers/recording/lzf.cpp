#include "drivers/recording/lzf.hpp"

#include <algorithm>
#include <cstddef>

namespace infuse::recording {

bool decompress_lzf(std::span<const uint8_t> compressed, std::span<uint8_t> out) {
  size_t from = 0;
  size_t to = 0;
  while (from < compressed.size()) {
    const size_t control = compressed[from++];
    if (control < 32) {
      const size_t length = control + 1;
      if (length > compressed.size() - from || length > out.size() - to) return false;
      std::copy_n(compressed.data() + from, length, out.data() + to);
      from += length;
      to += length;
      continue;
    }
    size_t length = (control >> 5) + 2;
    if (length == 9) {
      if (from == compressed.size()) return false;
      length += compressed[from++];
    }
    if (from == compressed.size()) return false;
    const size_t distance = ((control & 31) << 8) + compressed[from++] + 1;
    if (distance > to || length > out.size() - to) return false;
    // Byte by byte, because source and destination may overlap.
    for (const size_t end = to + length; to < end; ++to) out[to] = out[to - distance];
  }
  return to == out.size();
}

}  // namespace infuse::recording
