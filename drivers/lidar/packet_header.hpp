#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "drivers/lidar/firing_plan.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::lidar {

/// What is common to the data packets of all makers: when and whither their sequences fire. The
/// returns stay in the payload.
struct PacketHeader {
  Duration counter{0};  ///< device time of the first firing, 0 … `kMaxCounter`; may wrap
  /// Number of the packet, where the sensor counts its data packets; lost ones are then known
  /// exactly.
  std::optional<uint32_t> number{};
  uint16_t mode = 0;      ///< the maker's: how the returns are to be read
  uint8_t sequences = 0;  ///< number of firing sequences, 1 … `kMaxSequences`
  /// Azimuth of each sequence, 0.01°, 0 … 35999, clockwise, or `kNoAzimuth`.
  std::array<uint16_t, kMaxSequences> azimuth{};

  std::span<uint16_t> azimuths() { return {azimuth.data(), sequences}; }
  std::span<const uint16_t> azimuths() const { return {azimuth.data(), sequences}; }
};

/// Largest counter of a packet: 146 years.
inline constexpr Duration kMaxCounter{int64_t{1} << 62};

/// A data packet that is being decoded.
struct HeldPacket {
  std::span<const uint8_t> payload;
  const PacketHeader& header;
  int64_t device_ns;  ///< of the counter, unwrapped
};

}  // namespace infuse::lidar
