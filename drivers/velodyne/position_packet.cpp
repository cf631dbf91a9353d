#include "drivers/velodyne/position_packet.hpp"

#include <string_view>

#include "drivers/measurement/angles.hpp"
#include "drivers/velodyne/packet.hpp"

namespace infuse::velodyne {
namespace {

constexpr size_t kImuOffset = 14;
constexpr size_t kPositionCounterOffset = 0xC6;
constexpr size_t kPpsOffset = 0xCA;
constexpr size_t kSentenceOffset = 0xCE;
constexpr size_t kSentenceSize = 128;

/// Twelve bits, two's complement; the upper four bits number the quantity.
double signed12(const uint8_t* bytes) {
  const int low = read_u16(bytes) & 0x0FFF;
  return low >= 0x800 ? low - 0x1000 : low;
}

ImuUnit read_unit(const uint8_t* bytes) {
  constexpr double kAngularVelocity = 0.09766 * kDegree;  // rad/s
  constexpr double kTemperature = 0.1453;                 // °C
  constexpr double kAcceleration = 0.001221 * 9.80665;    // m/s²
  ImuUnit unit;
  unit.angular_velocity = signed12(bytes) * kAngularVelocity;
  unit.temperature = signed12(bytes + 2) * kTemperature + 25;
  unit.linear_acceleration = {signed12(bytes + 4) * kAcceleration,
                              signed12(bytes + 6) * kAcceleration};
  return unit;
}

}  // namespace

const char* name_of(PpsState state) {
  switch (state) {
    case PpsState::kAbsent:
      return "absent";
    case PpsState::kSynchronising:
      return "synchronising";
    case PpsState::kLocked:
      return "locked";
    case PpsState::kError:
      return "error";
  }
  return "";
}

bool counts_from_the_hour(const PositionPacket& packet) {
  constexpr int64_t kMinLeadUs = -100'000;
  constexpr int64_t kMaxLeadUs = 2'000'000;
  if (!packet.sentence || !packet.sentence->fix.valid) return false;
  const int64_t in_hour_us = packet.sentence->fix.utc_ns / 1000 % kHourUs;
  const int64_t lead_us =
      counter_difference_us(packet.counter_us, static_cast<uint32_t>(in_hour_us));
  return lead_us >= kMinLeadUs && lead_us <= kMaxLeadUs;
}

std::optional<PositionPacket> parse_position_packet(std::span<const uint8_t> payload) {
  if (payload.size() != kPositionPacketSize || payload[kPpsOffset] > 3) return std::nullopt;
  PositionPacket packet;
  packet.counter_us = read_u32(payload.data() + kPositionCounterOffset);
  packet.pps = static_cast<PpsState>(payload[kPpsOffset]);
  for (size_t unit = 0; unit < packet.imu.size(); ++unit) {
    packet.imu[unit] = read_unit(payload.data() + kImuOffset + 8 * unit);
  }
  packet.sentence = gnss::parse_nmea(std::string_view(
      reinterpret_cast<const char*>(payload.data()) + kSentenceOffset, kSentenceSize));
  return packet;
}

}  // namespace infuse::velodyne
