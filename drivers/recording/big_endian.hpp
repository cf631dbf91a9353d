#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace infuse::recording {

/// Integers in network order; the caller has checked that the bytes are there.
inline uint16_t read_u16(std::span<const uint8_t> bytes, size_t at) {
  return static_cast<uint16_t>(bytes[at] << 8 | bytes[at + 1]);
}
inline uint32_t read_u32(std::span<const uint8_t> bytes, size_t at) {
  return static_cast<uint32_t>(read_u16(bytes, at)) << 16 | read_u16(bytes, at + 2);
}

}  // namespace infuse::recording
