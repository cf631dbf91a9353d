#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace infuse::big_endian {

/// Reads an integer in network byte order at offset `at`. The caller ensures that the bytes exist.
inline uint16_t read_u16(std::span<const uint8_t> bytes, size_t at) {
  return static_cast<uint16_t>(bytes[at] << 8 | bytes[at + 1]);
}
/// Reads an integer in network byte order at offset `at`. The caller ensures that the bytes exist.
inline uint32_t read_u32(std::span<const uint8_t> bytes, size_t at) {
  return static_cast<uint32_t>(read_u16(bytes, at)) << 16 | read_u16(bytes, at + 2);
}

}  // namespace infuse::big_endian
