#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "fixtures/lidar/little_endian.hpp"
#include "tests/drivers/velodyne/oracle.hpp"

namespace infuse::velodyne {

/// A way in which recorded packets go wrong: one that occurs, not single random bytes.
struct MutationFamily {
  const char* name;
  /// Changes the data packets of one sensor.
  void (*apply)(std::vector<SentPacket>& packets, std::mt19937& random);
};

namespace mutation {

inline constexpr size_t kBlocks = 12;
inline constexpr size_t kAzimuth = 2, kCounter = 1200, kMode = 1204, kProduct = 1205;

using Packets = std::vector<SentPacket>;

/// Calls `change` for one packet of eight, and for one of them at least.
template <class Change>
void change_some(Packets& packets, std::mt19937& random, Change change) {
  const size_t sure = random() % packets.size();
  for (size_t i = 0; i < packets.size(); ++i) {
    if (i == sure || random() % 8 == 0) change(packets[i].payload);
  }
}

inline void set_random(std::vector<uint8_t>& payload, size_t at, std::mt19937& random) {
  payload[at] = static_cast<uint8_t>(random());
}

inline void set_azimuth(std::vector<uint8_t>& payload, size_t block, unsigned azimuth) {
  fixtures::write_u16(payload.data() + 100 * block + kAzimuth, static_cast<uint16_t>(azimuth));
}

inline unsigned azimuth_of(const std::vector<uint8_t>& payload, size_t block) {
  const size_t at = 100 * block + kAzimuth;
  return static_cast<unsigned>(payload[at] | payload[at + 1] << 8);
}

inline void product_bytes(Packets& packets, std::mt19937& random) {
  change_some(packets, random, [&](auto& payload) { set_random(payload, kProduct, random); });
}

inline void return_modes(Packets& packets, std::mt19937& random) {
  constexpr std::array<uint8_t, 4> kModes = {0x37, 0x38, 0x39, 0x3A};
  change_some(packets, random, [&](auto& payload) { payload[kMode] = kModes[random() % 4]; });
}

inline void one_flag(Packets& packets, std::mt19937& random) {
  constexpr std::array<uint16_t, 5> kFlags = {0xEEFF, 0xDDFF, 0xCCFF, 0xBBFF, 0};
  change_some(packets, random, [&](auto& payload) {
    fixtures::write_u16(payload.data() + 100 * (random() % kBlocks), kFlags[random() % 5]);
  });
}

inline void blocks_in_another_order(Packets& packets, std::mt19937& random) {
  change_some(packets, random, [&](auto& payload) {
    const auto begin = payload.begin();
    std::rotate(begin, begin + 100 * static_cast<ptrdiff_t>(1 + random() % (kBlocks - 1)),
                begin + 100 * kBlocks);
  });
}

inline void stray_azimuths(Packets& packets, std::mt19937& random) {
  change_some(packets, random, [&](auto& payload) {
    set_azimuth(payload, random() % kBlocks, static_cast<unsigned>(random() % 36000));
  });
}

inline void impossible_azimuths(Packets& packets, std::mt19937& random) {
  change_some(packets, random, [&](auto& payload) {
    const size_t first = random() % kBlocks;
    const size_t end = first + 1 + random() % (kBlocks - first);
    for (size_t block = first; block < end; ++block) {
      set_azimuth(payload, block, 36000 + static_cast<unsigned>(random() % 29536));
    }
  });
}

inline void standing_still(Packets& packets, std::mt19937& random) {
  const auto azimuth = static_cast<unsigned>(random() % 36000);
  for (SentPacket& packet : packets) {
    for (size_t block = 0; block < kBlocks; ++block) set_azimuth(packet.payload, block, azimuth);
  }
}

inline void turning_backwards(Packets& packets, std::mt19937&) {
  for (SentPacket& packet : packets) {
    for (size_t block = 0; block < kBlocks; ++block) {
      set_azimuth(packet.payload, block, (72000 - azimuth_of(packet.payload, block)) % 36000);
    }
  }
}

inline void other_lengths(Packets& packets, std::mt19937& random) {
  change_some(packets, random, [&](auto& payload) {
    constexpr std::array<size_t, 6> kLengths = {0, 512, 1205, 1207, 1248, 554};
    payload.resize(kLengths[random() % 6]);
  });
}

/// A second sensor of another model and phase at the same address and port.
inline void mixed_sensors(Packets& packets, std::mt19937& random) {
  const auto model = static_cast<Model>(random() % models().size());
  const Scene other = make_scene({.model = model,
                                  .start_azimuth = 100,
                                  .turns = 0.05,
                                  .calibration = built_in_calibration(model)});
  Packets mixed;
  for (size_t i = 0; i < packets.size(); ++i) {
    mixed.push_back(packets[i]);
    mixed.push_back({packets[i].stamp, other.packets[i % other.packets.size()].payload});
  }
  packets = std::move(mixed);
}

inline void lost_repeated_swapped(Packets& packets, std::mt19937& random) {
  Packets changed;
  for (const SentPacket& packet : packets) {
    const auto kind = random() % 8;
    if (kind == 0) continue;
    changed.push_back(packet);
    if (kind == 1) changed.push_back(packet);
    if (kind == 2 && changed.size() > 1) std::swap(changed.back(), changed[changed.size() - 2]);
  }
  if (!changed.empty()) packets = std::move(changed);
}

inline void jumping_counters(Packets& packets, std::mt19937& random) {
  change_some(packets, random, [&](auto& payload) {
    for (size_t i = 0; i < 4; ++i) set_random(payload, kCounter + i, random);
  });
}

}  // namespace mutation

/// All families.
inline std::span<const MutationFamily> mutation_families() {
  static constexpr std::array<MutationFamily, 12> kFamilies = {{
      {"product_bytes", mutation::product_bytes},
      {"return_modes", mutation::return_modes},
      {"one_flag", mutation::one_flag},
      {"blocks_in_another_order", mutation::blocks_in_another_order},
      {"stray_azimuths", mutation::stray_azimuths},
      {"impossible_azimuths", mutation::impossible_azimuths},
      {"standing_still", mutation::standing_still},
      {"turning_backwards", mutation::turning_backwards},
      {"other_lengths", mutation::other_lengths},
      {"mixed_sensors", mutation::mixed_sensors},
      {"lost_repeated_swapped", mutation::lost_repeated_swapped},
      {"jumping_counters", mutation::jumping_counters},
  }};
  return kFamilies;
}

}  // namespace infuse::velodyne
