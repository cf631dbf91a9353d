#include "drivers/robosense/packet.hpp"

#include <algorithm>
#include <chrono>

#include "drivers/lidar/azimuth.hpp"
#include "drivers/measurement/big_endian.hpp"

namespace infuse::robosense {
namespace {

constexpr std::array<uint8_t, 4> kDataMark{0x55, 0xAA, 0x05, 0x5A};
constexpr uint16_t kBlockFlag = 0xFFEE;
constexpr size_t kNumberOffset = 12;  // of the bottom board's counter; the top board's counts by 24
constexpr size_t kResolutionOffset = 17;
constexpr size_t kTimeOffset = 20;

/// Ten bytes: year since 2000, month, day, hour, minute, second, milliseconds, microseconds. A
/// month and day of 0 are those of a clock that is not set. Nothing: impossible.
std::optional<int64_t> read_date(std::span<const uint8_t> payload) {
  using namespace std::chrono;
  const auto part = [&](size_t i) { return payload[kTimeOffset + i]; };
  const year_month_day day(year(2000 + part(0)), month(std::max<unsigned>(part(1), 1)),
                           std::chrono::day(std::max<unsigned>(part(2), 1)));
  const auto since_midnight = hours(part(3)) + minutes(part(4)) + seconds(part(5)) +
                              milliseconds(big_endian::read_u16(payload, kTimeOffset + 6)) +
                              microseconds(big_endian::read_u16(payload, kTimeOffset + 8));
  if (!day.ok() || since_midnight > days(1)) return std::nullopt;
  return nanoseconds(sys_days(day).time_since_epoch() + since_midnight).count();
}

/// Six bytes of seconds, four of microseconds. Nothing: impossible.
std::optional<int64_t> read_seconds(std::span<const uint8_t> payload) {
  constexpr int64_t kMaxSeconds = 4'000'000'000;
  constexpr uint32_t kMicrosecondsPerSecond = 1'000'000;
  const int64_t seconds = int64_t{big_endian::read_u16(payload, kTimeOffset)} << 32 |
                          big_endian::read_u32(payload, kTimeOffset + 2);
  const uint32_t microseconds = big_endian::read_u32(payload, kTimeOffset + 6);
  if (seconds > kMaxSeconds || microseconds >= kMicrosecondsPerSecond) return std::nullopt;
  return (seconds * kMicrosecondsPerSecond + microseconds) * 1000;
}

/// Reads the blocks' azimuths and what they show; a fault if most cannot be, or a flag is missing.
std::optional<PacketFault> read_azimuths(std::span<const uint8_t> payload, Packet& packet) {
  size_t impossible = 0;
  for (size_t block = 0; block < kBlocks; ++block) {
    const size_t at = kHeaderSize + block * kBlockSize;
    if (big_endian::read_u16(payload, at) != kBlockFlag) return PacketFault::kFlag;
    const uint16_t azimuth = big_endian::read_u16(payload, at + 2);
    const bool possible = azimuth <= lidar::kCentidegreesPerTurn;
    packet.azimuth[block] = possible ? azimuth % lidar::kCentidegreesPerTurn : lidar::kNoAzimuth;
    impossible += possible ? 0 : 1;
  }
  if (2 * impossible >= kBlocks) return PacketFault::kAzimuth;
  packet.stands =
      std::ranges::all_of(packet.azimuth, [&](uint16_t each) { return each == packet.azimuth[0]; });
  packet.repeats_azimuths = !packet.stands;
  for (size_t block = 0; block < kBlocks; block += 2) {
    packet.repeats_azimuths &= packet.azimuth[block] == packet.azimuth[block + 1];
  }
  return std::nullopt;
}

}  // namespace

const char* describe(PacketFault fault) {
  switch (fault) {
    case PacketFault::kSize:
      return "not 1248 bytes";
    case PacketFault::kHeader:
      return "does not begin as the data packets of an RS-Helios or RS-Bpearl do";
    case PacketFault::kFlag:
      return "a block does not begin with its flag";
    case PacketFault::kAzimuth:
      return "most azimuths are above 360 degrees";
    case PacketFault::kTime:
      return "an impossible device time";
  }
  return "";
}

bool is_data_packet(std::span<const uint8_t> payload) {
  if (payload.size() != kPacketSize) return false;
  return is_older_format(payload) ? stated_model(payload).has_value()
                                  : std::equal(kDataMark.begin(), kDataMark.end(), payload.begin());
}

bool is_foreign_data_packet(std::span<const uint8_t> payload) {
  constexpr std::array<std::array<uint8_t, 4>, 3> kMarks{{
      kDataMark,                 // of another size
      {0x55, 0xAA, 0x05, 0x0A},  // RS-LiDAR-16 and -32, RS-Ruby
      {0x55, 0xAA, 0x5A, 0xA5},  // M and E series
  }};
  constexpr size_t kSmallest = 1000;
  return payload.size() >= kSmallest && !is_data_packet(payload) &&
         std::ranges::any_of(kMarks, [&](const auto& mark) {
           return std::equal(mark.begin(), mark.end(), payload.begin());
         });
}

tl::expected<Packet, PacketFault> parse_packet(std::span<const uint8_t> payload) {
  if (payload.size() != kPacketSize) return tl::unexpected(PacketFault::kSize);
  if (!is_data_packet(payload)) return tl::unexpected(PacketFault::kHeader);
  Packet packet;
  if (const auto fault = read_azimuths(payload, packet)) return tl::unexpected(*fault);
  const bool is_bpearl = is_older_format(payload);
  const bool coarse = is_bpearl && stated_model(payload) == Model::kBpearl;  // versions 2 and 3
  const auto time = coarse ? read_date(payload) : read_seconds(payload);
  if (!time) return tl::unexpected(PacketFault::kTime);
  packet.time_ns = *time;
  if (const uint32_t number = big_endian::read_u32(payload, kNumberOffset)) packet.number = number;
  packet.distance_unit =
      coarse || (!is_bpearl && payload[kResolutionOffset] == 0) ? 0.005F : 0.0025F;
  return packet;
}

const char* name_of(ReturnMode mode) {
  switch (mode) {
    case ReturnMode::kDual:
      return "two returns";
    case ReturnMode::kStrongest:
      return "strongest return";
    case ReturnMode::kLast:
      return "last return";
    case ReturnMode::kFirst:
      return "first return";
  }
  return "";
}

std::array<ReturnKind, 2> return_kinds(ReturnMode mode) {
  switch (mode) {
    case ReturnMode::kDual:
      return {ReturnKind::kStrongest, ReturnKind::kSecondStrongest};
    case ReturnMode::kStrongest:
      return {ReturnKind::kStrongest};
    case ReturnMode::kLast:
      return {ReturnKind::kLast};
    case ReturnMode::kFirst:
      return {ReturnKind::kFirst};
  }
  return {};
}

}  // namespace infuse::robosense
