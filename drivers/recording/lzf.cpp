#include "drivers/recording/lzf.hpp"

#include <algorithm>
#include <cstddef>

namespace infuse::recording {

bool unpack_lzf(std::span<const uint8_t> packed, std::span<uint8_t> out) {
  size_t from = 0;
  size_t to = 0;
  while (from < packed.size()) {
    const size_t control = packed[from++];
    if (control < 32) {
      const size_t length = control + 1;
      if (length > packed.size() - from || length > out.size() - to) return false;
      std::copy_n(packed.data() + from, length, out.data() + to);
      from += length;
      to += length;
      continue;
    }
    size_t length = (control >> 5) + 2;
    if (length == 9) {
      if (from == packed.size()) return false;
      length += packed[from++];
    }
    if (from == packed.size()) return false;
    const size_t back = ((control & 31) << 8) + packed[from++] + 1;
    if (back > to || length > out.size() - to) return false;
    // Byte by byte: what is copied may reach into what it has made.
    for (const size_t end = to + length; to < end; ++to) out[to] = out[to - back];
  }
  return to == out.size();
}

}  // namespace infuse::recording
