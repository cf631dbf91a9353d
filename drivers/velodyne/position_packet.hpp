#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <tl/expected.hpp>

#include "drivers/gnss/nmea.hpp"
#include "drivers/measurement/vehicle_samples.hpp"

namespace infuse::velodyne {

/// Bytes of a position packet's payload (UDP port 8308).
inline constexpr size_t kPositionPacketSize = 512;

/// State of the sensor's pulse-per-second input. HDL-32E firmware of 2012 always reports absent.
enum class PpsState : uint8_t { kAbsent = 0, kSynchronising = 1, kLocked = 2, kError = 3 };

/// Name of the state: "absent", "synchronising", "locked", "error".
const char* name_of(PpsState state);

/// One of the three inertial units in an HDL-32E: a gyroscope and two axes of acceleration, in the
/// unit's own directions. In real captures x of the first two units points up, and of the
/// horizontal axes y of the second is y of the third, y of the first minus x of the third. The
/// available captures do not show which of them points forward, so the units stay separate.
struct ImuUnit {
  double angular_velocity = 0;                  ///< rad/s
  double temperature = 0;                       ///< °C
  std::array<double, 2> linear_acceleration{};  ///< m/s²: its x and y
};

/// Content of a position packet.
struct PositionPacket {
  uint32_t counter_us = 0;  ///< device time: µs since the top of the hour, or since power-up
  PpsState pps = PpsState::kAbsent;
  std::array<ImuUnit, 3> imu{};  ///< HDL-32E only; zero bytes on others read as 25 °C
  tl::expected<gnss::NmeaFix, gnss::NmeaFault>
      sentence;  ///< last sentence of the GNSS receiver, up to a second old: its date and hour are
                 ///< reliable, its seconds are not
};

/// True if the packet's counter runs from the top of the hour of its sentence, whose second it may
/// lead by up to two: the receiver sends a sentence up to a second late, and it stays for another.
bool counts_from_the_hour(const PositionPacket& packet);

/// Parses a payload; nothing if it is not 512 bytes or the PPS byte is not one of the four.
std::optional<PositionPacket> parse_position_packet(std::span<const uint8_t> payload);

}  // namespace infuse::velodyne
