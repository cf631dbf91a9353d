#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "drivers/hesai/packet.hpp"

namespace infuse::hesai {

/// One unit of a block.
struct MadeUnit {
  uint16_t distance = 0;  ///< in units of the packet
  uint8_t reflectivity = 0;
};

/// What a packet is made of; the layout is written down here again, from the manuals.
struct MadePacket {
  Model model = Model::kXt32;
  ReturnMode mode = ReturnMode::kStrongest;
  std::vector<uint16_t> azimuths{};  ///< 0.01°, one for each firing
  uint16_t motor_speed = 600;
  std::vector<uint8_t> date{119, 7, 25, 3, 19, 29};
  uint32_t microseconds = 0;
  uint32_t number = 0;
  bool has_number = true;
  uint8_t unit_mm = 4;
  uint8_t mode_flag = 1;      ///< QT128
  bool has_safety = true;     ///< QT128
  bool has_signature = true;  ///< QT128
  /// Unit of a channel in a block.
  std::function<MadeUnit(size_t block, size_t channel)> unit = [](size_t, size_t) {
    return MadeUnit{};
  };
};

class Bytes {
 public:
  void u8(int value) { bytes_.push_back(static_cast<uint8_t>(value)); }
  void u16(int value) {
    u8(value & 0xFF);
    u8(value >> 8);
  }
  void u32(uint32_t value) {
    u16(static_cast<int>(value & 0xFFFF));
    u16(static_cast<int>(value >> 16));
  }
  void zeros(size_t count) { bytes_.insert(bytes_.end(), count, 0); }
  void all(const std::vector<uint8_t>& more) {
    bytes_.insert(bytes_.end(), more.begin(), more.end());
  }
  std::vector<uint8_t> take() { return std::move(bytes_); }

 private:
  std::vector<uint8_t> bytes_;
};

inline int lasers_of(Model model) {
  switch (model) {
    case Model::kPandar40p:
      return 40;
    case Model::kPandar64:
    case Model::kQt64:
      return 64;
    case Model::kQt128:
      return 128;
    case Model::kXt16:
      return 16;
    case Model::kXt32:
    case Model::kXt32m:
      return 32;
  }
  return 0;
}

inline int blocks_of(Model model) {
  switch (model) {
    case Model::kPandar40p:
      return 10;
    case Model::kPandar64:
    case Model::kXt32m:
      return 6;
    case Model::kQt64:
      return 4;
    case Model::kQt128:
      return 2;
    case Model::kXt16:
    case Model::kXt32:
      return 8;
  }
  return 0;
}

inline int returns_of(ReturnMode mode) {
  const int byte = static_cast<int>(mode);
  return byte < 0x39 ? 1 : byte == 0x3D ? 3 : 2;
}

inline void add_made_header(const MadePacket& made, Bytes& bytes) {
  const int lasers = lasers_of(made.model);
  const int blocks = blocks_of(made.model);
  switch (made.model) {
    case Model::kPandar40p:
      return;
    case Model::kPandar64:
      bytes.all({0xEE, 0xFF, static_cast<uint8_t>(lasers), static_cast<uint8_t>(blocks), 0,
                 made.unit_mm, 0, 0});
      return;
    default:
      break;
  }
  const bool xt = lasers <= 32;
  bytes.all(
      {0xEE, 0xFF, static_cast<uint8_t>(xt ? 6 : 3), static_cast<uint8_t>(lasers == 128 ? 2 : 1), 0,
       0, static_cast<uint8_t>(lasers), static_cast<uint8_t>(blocks), 0, made.unit_mm,
       static_cast<uint8_t>(returns_of(made.mode)), static_cast<uint8_t>(made.has_number ? 1 : 0)});
}

inline void add_made_tail(const MadePacket& made, Bytes& bytes) {
  const int mode = static_cast<int>(made.mode);
  switch (made.model) {
    case Model::kPandar40p:
    case Model::kPandar64: {
      std::vector<uint8_t> date = made.date;
      if (date[0] >= 100) date[0] = static_cast<uint8_t>(date[0] - 100);  // years since 2000
      bytes.zeros(8);
      bytes.u16(made.motor_speed);
      bytes.u32(made.microseconds);
      bytes.u8(mode);
      bytes.u8(0x42);
      bytes.all(date);
      break;
    }
    case Model::kQt64:
      bytes.zeros(10);
      bytes.u16(made.motor_speed);
      bytes.u32(made.microseconds);
      bytes.u8(mode);
      bytes.u8(0x42);
      bytes.all(made.date);
      break;
    case Model::kQt128:
      bytes.zeros(4 + (made.has_safety ? 17 : 0) + 5);
      bytes.u8(made.mode_flag);
      bytes.zeros(6);
      bytes.u8(mode);
      bytes.u16(made.motor_speed);
      bytes.all(made.date);
      bytes.u32(made.microseconds);
      bytes.u8(0x42);
      break;
    case Model::kXt16:
    case Model::kXt32:
    case Model::kXt32m:
      bytes.zeros(10);
      bytes.u8(mode);
      bytes.u16(made.motor_speed);
      bytes.all(made.date);
      bytes.u32(made.microseconds);
      bytes.u8(0x42);
      break;
  }
  if (made.has_number) bytes.u32(made.number);
  if (made.model == Model::kQt128) bytes.zeros(made.has_signature ? 36 : 4);
}

/// The bytes of a packet.
inline std::vector<uint8_t> make_packet(const MadePacket& made) {
  Bytes bytes;
  add_made_header(made, bytes);
  const bool short_unit = made.model == Model::kPandar40p || made.model == Model::kPandar64;
  for (int block = 0; block < blocks_of(made.model); ++block) {
    if (made.model == Model::kPandar40p) bytes.all({0xFF, 0xEE});
    const auto firing = static_cast<size_t>(block / returns_of(made.mode));
    bytes.u16(firing < made.azimuths.size() ? made.azimuths[firing] : 0);
    for (int channel = 0; channel < lasers_of(made.model); ++channel) {
      const MadeUnit unit = made.unit(static_cast<size_t>(block), static_cast<size_t>(channel));
      bytes.u16(unit.distance);
      bytes.u8(unit.reflectivity);
      if (!short_unit) bytes.u8((block * 37 + channel) & 0xFF);  // not used
    }
  }
  add_made_tail(made, bytes);
  return bytes.take();
}

}  // namespace infuse::hesai
