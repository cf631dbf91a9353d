#pragma once

#include <cmath>
#include <cstdint>
#include <ctime>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "drivers/measurement/datagram.hpp"

namespace infuse::robosense {

/// What the layout of packets depends on. Number of beams of an RS-Helios, or the version of an
/// RS-Bpearl (3, 4).
struct PlainModel {
  PlainModel(int beams, int bpearl_version = 0) : lasers(beams), bpearl(bpearl_version) {}
  double firing_us() const { return bpearl == 3 ? 55.52 : 55.556; }
  double unit_m() const { return bpearl == 3 ? 0.005 : 0.0025; }
  int lasers, bpearl;
};

/// A packet as received from the network.
struct SentPacket {
  Stamp stamp;
  std::vector<uint8_t> payload;
  uint16_t port = 6699;
  uint32_t sender = 0x0A000007;

  Datagram datagram() const { return {stamp, sender, 10'000, port, payload}; }
};

/// Writes a number, the high byte first.
inline void put(std::vector<uint8_t>& bytes, size_t at, uint64_t value, size_t size) {
  for (size_t i = 0; i < size; ++i) {
    const size_t shift = 8 * (size - 1 - i);  // of 10 bytes the highest are 0
    bytes[at + i] = shift < 64 ? static_cast<uint8_t>(value >> shift) : uint8_t{0};
  }
}

/// A data packet without returns; the layout is written down here again, from the manual.
inline std::vector<uint8_t> make_data_packet(uint32_t number, uint64_t seconds,
                                             uint32_t microseconds,
                                             const std::vector<uint16_t>& azimuths,
                                             uint8_t type = 6, uint8_t model = 0) {
  std::vector<uint8_t> bytes(1248, 0);
  put(bytes, 0, 0x55AA055A, 4);
  put(bytes, 4, 1, 2);
  put(bytes, 12, number, 4);
  bytes[17] = 1;
  put(bytes, 20, seconds, 6);
  put(bytes, 26, microseconds, 4);
  bytes[30] = type;
  bytes[31] = model;
  for (size_t block = 0; block < 12; ++block) {
    put(bytes, 42 + 100 * block, 0xFFEE, 2);
    put(bytes, 44 + 100 * block, azimuths[block], 2);
  }
  bytes[1247] = 0xFF;
  return bytes;
}

/// The data packet of an RS-Bpearl: another mark and type, no unit of distance; version 3 with a
/// date and time of day.
inline std::vector<uint8_t> make_bpearl_packet(int version, uint32_t number, uint64_t seconds,
                                               uint32_t microseconds,
                                               const std::vector<uint16_t>& azimuths) {
  auto bytes = make_data_packet(number, seconds, microseconds, azimuths, 0);
  put(bytes, 0, 0x55AA050A5AA550A0, 8);
  put(bytes, 30, version == 4 ? 0x000304 : 0x030000, 3);
  bytes[17] = 0;
  if (version == 4) return bytes;
  const auto time = static_cast<time_t>(seconds);
  tm date{};
  gmtime_r(&time, &date);
  const int parts[]{date.tm_year - 100, date.tm_mon + 1, date.tm_mday,
                    date.tm_hour,       date.tm_min,     date.tm_sec};
  for (size_t i = 0; i < 6; ++i) bytes[20 + i] = static_cast<uint8_t>(parts[i]);
  put(bytes, 26, microseconds / 1'000, 2);
  put(bytes, 28, microseconds % 1'000, 2);
  return bytes;
}

/// An information packet of a unit whose angles are given in 0.01°; channels without one are empty.
inline std::vector<uint8_t> make_info_packet(const std::vector<int>& elevations,
                                             const std::vector<int>& azimuths, uint8_t mode = 4,
                                             const std::string& sentence = "") {
  std::vector<uint8_t> bytes(1248, 0xFF);
  put(bytes, 0, 0xA5FF005A11115555, 8);
  put(bytes, 8, 600, 2);
  bytes[300] = mode;
  bytes[301] = 3;
  bytes[302] = 2;
  for (size_t i = 0; i < 86; ++i) {
    bytes[382 + i] = i < sentence.size() ? static_cast<uint8_t>(sentence[i]) : 0;
  }
  const auto put_angle = [&](size_t at, int angle) {
    bytes[at] = static_cast<uint8_t>(angle < 0);
    put(bytes, at + 1, static_cast<uint64_t>(std::abs(angle)), 2);
  };
  for (size_t i = 0; i < elevations.size(); ++i) put_angle(468 + 3 * i, elevations[i]);
  for (size_t i = 0; i < azimuths.size(); ++i) put_angle(564 + 3 * i, azimuths[i]);
  put(bytes, 1246, 0x0FF0, 2);
  return bytes;
}

/// Data packets of a lidar that turns ten times a second and sees random ranges; every fourth
/// direction has none, every third pair of returns is one.
inline std::vector<SentPacket> make_turns(PlainModel model, bool dual, double turns) {
  const int lasers = model.lasers;
  const double firing_us = model.firing_us();
  const double block_us = lasers == 16 ? (dual ? 1 : 2) * firing_us : firing_us;
  const int blocks_each = dual && lasers == 32 ? 2 : 1;
  const double packet_us = block_us * 12 / blocks_each;
  std::mt19937 random(1);
  std::vector<SentPacket> sent;
  for (uint32_t k = 0; k * packet_us < turns * 1e5; ++k) {
    std::vector<uint16_t> azimuths;
    for (int block = 0; block < 12; ++block) {
      const double us = k * packet_us + block / blocks_each * block_us;
      azimuths.push_back(static_cast<uint16_t>(std::lround(35'000 + us * 0.36) % 36'000));
    }
    const auto us = static_cast<uint32_t>(std::lround(500 + k * packet_us));
    auto bytes = model.bpearl != 0
                     ? make_bpearl_packet(model.bpearl, 7'000 + k, 1'700'000'000, us, azimuths)
                     : make_data_packet(7'000 + k, 1'700'000'000, us, azimuths,
                                        lasers == 16 ? uint8_t{7} : uint8_t{6});
    const auto unit_at = [](int block, int unit) {
      return static_cast<size_t>(46 + 100 * block + 3 * unit);
    };
    for (int block = 0; block < 12; ++block) {
      for (int unit = 0; unit < 32; ++unit) {
        put(bytes, unit_at(block, unit), random() % 4 == 0 ? 0 : 1 + random() % 65'535, 2);
        bytes[unit_at(block, unit) + 2] = static_cast<uint8_t>(random());
        const bool second = dual && (lasers == 16 ? unit >= 16 : block % 2 == 1);
        if (!second || random() % 3 != 0) continue;
        const size_t first = lasers == 16 ? unit_at(block, unit - 16) : unit_at(block - 1, unit);
        std::copy_n(bytes.begin() + static_cast<ptrdiff_t>(first), 3,
                    bytes.begin() + static_cast<ptrdiff_t>(unit_at(block, unit)));
      }
    }
    sent.push_back({Stamp::from_ns(1'700'000'000'000'000'000 +
                                   std::llround(1e3 * (560 + (k + 1) * packet_us))),
                    std::move(bytes)});
  }
  return sent;
}

}  // namespace infuse::robosense
