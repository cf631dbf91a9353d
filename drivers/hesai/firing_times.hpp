#pragma once

#include <array>
#include <cstdint>

#include "drivers/hesai/packet.hpp"

namespace infuse::hesai {

/// When the channels fire, ns.
struct FiringTimes {
  /// Time of each channel after its block's time (`block_time_ns`).
  std::array<int32_t, kMaxLasers> channel_ns{};
  /// Time of the earliest channel.
  int32_t first_ns = 0;
  /// Time of the last channel.
  int32_t last_ns = 0;
  /// A block's azimuth is the rotor's this long after the block's time.
  int32_t azimuth_ns = 0;
};

/// Firing times of a model's channels, from the manuals' appendix on laser firing times and Hesai's
/// firing time correction files (which give the azimuth's time). `loop` is 0, but for a QT128,
/// which has two firing sequences: channels that do not fire in one have the time of its first.
FiringTimes firing_times(Model model, size_t loop);

/// Number of firing sequences that alternate: 2 for a QT128, else 1.
size_t number_of_loops(Model model);

/// Time of firing `sequence` (0 …) after the packet's time.
int64_t block_time_ns(Model model, const Packet& packet, size_t sequence);

}  // namespace infuse::hesai
