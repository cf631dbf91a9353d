#pragma once

#include <cstdint>

namespace infuse::lidar {

/// Little-endian numbers, from any address.
constexpr uint16_t read_u16(const uint8_t* bytes) {
  return static_cast<uint16_t>(bytes[0] | bytes[1] << 8);
}
constexpr uint32_t read_u32(const uint8_t* bytes) {
  return static_cast<uint32_t>(read_u16(bytes)) | static_cast<uint32_t>(read_u16(bytes + 2)) << 16;
}
constexpr uint64_t read_u64(const uint8_t* bytes) {
  return static_cast<uint64_t>(read_u32(bytes)) | static_cast<uint64_t>(read_u32(bytes + 4)) << 32;
}

}  // namespace infuse::lidar
