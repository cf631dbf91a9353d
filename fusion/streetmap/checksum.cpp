#include "fusion/streetmap/checksum.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

namespace infuse::streetmap {

uint64_t checksum(std::span<const std::byte> bytes, uint64_t seed) {
  constexpr uint64_t kOdd = 0x9E3779B97F4A7C15;
  std::array<uint64_t, 4> lanes{seed + 1, seed + 2, seed + 3, seed + 4};
  for (size_t at = 0; at < bytes.size(); at += 32) {
    std::array<uint64_t, 4> words{};
    std::memcpy(words.data(), bytes.data() + at, std::min<size_t>(32, bytes.size() - at));
    for (size_t k = 0; k < 4; ++k) lanes[k] = std::rotl((lanes[k] ^ words[k]) * kOdd, 29);
  }
  uint64_t sum = bytes.size();
  for (const uint64_t lane : lanes) sum = std::rotl((sum ^ lane) * kOdd, 31);
  return sum ^ sum >> 32;
}

}  // namespace infuse::streetmap
