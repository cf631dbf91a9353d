#pragma once

#include <cstdint>
#include <cstring>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "drivers/ouster/metadata.hpp"

namespace infuse::ouster {

/// A pixel of a made packet, by what it means.
struct MadePixel {
  uint32_t range = 0, range2 = 0;  ///< mm
  uint8_t reflectivity = 0, reflectivity2 = 0;
  uint16_t near_infrared = 0;
};

/// What a made packet holds. Times are those of a steady sensor.
struct MadePacket {
  uint32_t frame_id = 0;
  uint16_t first_measurement_id = 0;
  int64_t device_ns = 1'000'000'000;  ///< of the first column
  int64_t column_ns = 97'656;
  uint64_t invalid_columns = 0;  ///< bit i: column i is not valid
  uint16_t type = 1;
  uint32_t initialization_id = 5'431'293;
  uint64_t serial_number = 992'110'000'123;
  std::function<MadePixel(uint16_t measurement_id, size_t beam)> pixel = [](uint16_t, size_t) {
    return MadePixel{10'000, 0, 100, 0, 7};
  };
};

/// Appends a little-endian number.
template <class T>
void put(std::vector<uint8_t>& bytes, T value) {
  const size_t at = bytes.size();
  bytes.resize(at + sizeof value);
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

/// Appends a pixel as Ouster's manual draws it.
inline void put_pixel(std::vector<uint8_t>& bytes, Profile profile, const MadePixel& pixel) {
  const auto word = [&](uint32_t value) { put<uint32_t>(bytes, value); };
  const uint32_t first = static_cast<uint32_t>(pixel.reflectivity) << 24;
  const uint32_t second = static_cast<uint32_t>(pixel.reflectivity2) << 24;
  switch (profile) {
    case Profile::kLegacy:
    case Profile::kRng19:
    case Profile::kRng19Zone:
      word(pixel.range);
      word(pixel.reflectivity | 0x1234u << 16);  // signal in the upper half
      return word(pixel.near_infrared | (profile == Profile::kRng19Zone ? 0x5678u << 16 : 0));
    case Profile::kRng19Dual:
      word(pixel.range | first);
      word(pixel.range2 | second);
      word(0x12345678);  // signals
      return word(pixel.near_infrared);
    case Profile::kRng19ZoneDual:
      word(pixel.range | first);
      word(pixel.range2 | second);
      word(0x12345678);         // signals
      return word(0x9A005678);  // window, zones
    case Profile::kRng15:
    case Profile::kRng15Window:
      return word(pixel.range / 8 | first >> 8 | static_cast<uint32_t>(pixel.near_infrared) << 24);
    case Profile::kRng15Zone:
      word(pixel.range / 8 | first >> 8 | static_cast<uint32_t>(pixel.near_infrared) << 24);
      return word(0x009A5678);  // window, zones
    case Profile::kFusaDual:
    case Profile::kRng15Dual:
      word(pixel.range / 8 | first >> 8 | static_cast<uint32_t>(pixel.near_infrared) << 24);
      return word(pixel.range2 / 8 | second >> 8);
  }
}

/// Appends the packet's header of 32 bytes.
inline void put_header(std::vector<uint8_t>& bytes, bool fusa, const MadePacket& packet) {
  if (fusa) {
    put<uint32_t>(bytes, packet.type | packet.initialization_id << 8);
    put<uint32_t>(bytes, packet.frame_id);
    bytes.resize(11);
    put<uint64_t>(bytes, packet.serial_number);
  } else {
    put<uint16_t>(bytes, packet.type);
    put<uint16_t>(bytes, static_cast<uint16_t>(packet.frame_id));
    put<uint32_t>(bytes, packet.initialization_id);
    bytes.resize(7);
    put<uint64_t>(bytes, packet.serial_number);
  }
  bytes.resize(32);
}

/// The payload of a lidar packet of a sensor with this metadata.
inline std::vector<uint8_t> made_packet(const Metadata& metadata, const MadePacket& packet) {
  std::vector<uint8_t> bytes;
  const bool legacy = metadata.profile == Profile::kLegacy;
  if (!legacy) put_header(bytes, metadata.fusa_header, packet);
  for (uint16_t i = 0; i < metadata.columns_per_packet; ++i) {
    const int id = packet.first_measurement_id + i;
    const auto measurement_id = static_cast<uint16_t>(id % metadata.columns_per_turn);
    const bool valid = (packet.invalid_columns >> i & 1) == 0;
    put<int64_t>(bytes, packet.device_ns + i * packet.column_ns);
    put<uint16_t>(bytes, measurement_id);
    if (legacy) {
      const bool next_turn = id >= metadata.columns_per_turn;
      put<uint16_t>(bytes, static_cast<uint16_t>(packet.frame_id + (next_turn ? 1 : 0)));
      put<uint32_t>(bytes, 88u * measurement_id);
    } else {
      put<uint16_t>(bytes, valid ? 1 : 0);
    }
    for (size_t beam = 0; beam < metadata.beams(); ++beam) {
      put_pixel(bytes, metadata.profile, packet.pixel(measurement_id, beam));
    }
    if (legacy) put<uint32_t>(bytes, valid ? 0xFFFF'FFFF : 0);
  }
  if (!legacy) bytes.resize(bytes.size() + 32);
  return bytes;
}

}  // namespace infuse::ouster
