#include "drivers/hesai/packet.hpp"

#include <chrono>

#include "drivers/lidar/azimuth.hpp"
#include "drivers/lidar/little_endian.hpp"

namespace infuse::hesai {
namespace {

using lidar::read_u16;
using lidar::read_u32;

/// Where a packet's tail and its counter begin.
struct TailPlace {
  size_t tail = 0;
  std::optional<size_t> number;
};

/// A QT128's blocks are followed by a checksum, 17 bytes of functional safety (optional), the tail,
/// the counter (optional), a checksum and a signature of 32 bytes (optional). Every combination has
/// its own length.
std::optional<TailPlace> find_qt128_tail(const ModelInfo& info, size_t size) {
  constexpr size_t kChecksum = 4;
  constexpr size_t kSafety = 17;
  constexpr size_t kNumber = 4;
  constexpr size_t kSignature = 32;
  const size_t least = info.body_end() + kChecksum + info.tail.size + kChecksum;
  if (size < least) return std::nullopt;
  size_t rest = size - least;
  if (rest >= kSignature) rest -= kSignature;
  TailPlace place{info.body_end() + kChecksum, std::nullopt};
  if (rest >= kSafety) {
    rest -= kSafety;
    place.tail += kSafety;
  }
  if (rest == kNumber) {
    place.number = place.tail + info.tail.size;
  } else if (rest != 0) {
    return std::nullopt;
  }
  return place;
}

std::optional<TailPlace> find_tail(const ModelInfo& info, size_t size) {
  constexpr size_t kNumber = 4;
  constexpr size_t kMaxAppended = 64;  // the counter, and a signature on some firmware
  if (info.model == Model::kQt128) return find_qt128_tail(info, size);
  const size_t end = info.body_end() + info.tail.size;
  if (size < end || size > end + kMaxAppended) return std::nullopt;
  TailPlace place{info.body_end(), std::nullopt};
  if (size >= end + kNumber) place.number = end;
  return place;
}

/// Nanoseconds since 1970 of six bytes: year (since 2000, or since 1900), month, day, hour, minute,
/// second; or, after two zero bytes, seconds since 1970 with the highest byte first.
std::optional<int64_t> read_second(const uint8_t* date) {
  using namespace std::chrono;
  if (date[0] == 0 && date[1] == 0) {
    return duration_cast<nanoseconds>(
               seconds(int64_t{date[2]} << 24 | date[3] << 16 | date[4] << 8 | date[5]))
        .count();
  }
  const year_month_day day(year(date[0] + (date[0] < 100 ? 2000 : 1900)), month(date[1]),
                           std::chrono::day(date[2]));
  constexpr int kLeapSecond = 60;
  if (!day.ok() || date[3] > 23 || date[4] > 59 || date[5] > kLeapSecond) return std::nullopt;
  const auto time = sys_days(day) + hours(date[3]) + minutes(date[4]) + seconds(date[5]);
  return duration_cast<nanoseconds>(time.time_since_epoch()).count();
}

std::optional<int64_t> read_time(const TailLayout& layout, const uint8_t* tail) {
  constexpr uint32_t kMicrosecondsPerSecond = 1'000'000;
  const auto second = read_second(tail + layout.date);
  const uint32_t microseconds = read_u32(tail + layout.microseconds);
  if (!second || microseconds >= kMicrosecondsPerSecond) return std::nullopt;
  return *second + microseconds * int64_t{1000};
}

/// Azimuth of a firing, the same in all its blocks; `kNoAzimuth` if it is impossible.
uint16_t read_azimuth(const ModelInfo& info, const Packet& packet, size_t firing,
                      std::span<const uint8_t> payload) {
  const uint8_t* at = payload.data() + info.header_size + info.block_prefix - 2 +
                      firing * packet.returns * info.block_size();
  const uint16_t azimuth = read_u16(at);
  for (size_t i = 1; i < packet.returns; ++i) {
    if (read_u16(at + i * info.block_size()) != azimuth) return lidar::kNoAzimuth;
  }
  if (azimuth > lidar::kCentidegreesPerTurn) return lidar::kNoAzimuth;
  return azimuth % lidar::kCentidegreesPerTurn;
}

/// Reads the azimuths of all firings; false if most are impossible.
bool read_azimuths(const ModelInfo& info, std::span<const uint8_t> payload, Packet& packet) {
  size_t possible = 0;
  for (size_t firing = 0; firing < packet.sequences; ++firing) {
    packet.azimuth[firing] = read_azimuth(info, packet, firing, payload);
    possible += packet.azimuth[firing] != lidar::kNoAzimuth ? 1 : 0;
  }
  return 2 * possible > packet.sequences;
}

uint8_t distance_unit(const ModelInfo& info, std::span<const uint8_t> payload) {
  constexpr uint8_t kPandar40pUnit = 4;
  if (info.header_size == 0) return kPandar40pUnit;
  return payload[info.header_size == 8 ? 5 : 9];
}

/// Firing sequence of a QT128 packet's first firing: mode flag 1 is the first, 2 the second.
uint8_t first_loop(const ModelInfo& info, const uint8_t* tail) {
  constexpr size_t kModeFlag = 5;
  return info.model == Model::kQt128 ? static_cast<uint8_t>((tail[kModeFlag] + 1) % 2) : uint8_t{0};
}

}  // namespace

size_t number_of_returns(ReturnMode mode) {
  switch (mode) {
    case ReturnMode::kFirst:
    case ReturnMode::kSecond:
    case ReturnMode::kStrongest:
    case ReturnMode::kLast:
      return 1;
    case ReturnMode::kLastStrongest:
    case ReturnMode::kFirstSecond:
    case ReturnMode::kFirstLast:
    case ReturnMode::kFirstStrongest:
    case ReturnMode::kStrongestSecond:
      return 2;
    case ReturnMode::kFirstLastStrongest:
      return 3;
  }
  return 0;
}

const char* name_of(ReturnMode mode) {
  switch (mode) {
    case ReturnMode::kFirst:
      return "first";
    case ReturnMode::kSecond:
      return "second";
    case ReturnMode::kStrongest:
      return "strongest";
    case ReturnMode::kLast:
      return "last";
    case ReturnMode::kLastStrongest:
      return "last and strongest";
    case ReturnMode::kFirstSecond:
      return "first and second";
    case ReturnMode::kFirstLast:
      return "first and last";
    case ReturnMode::kFirstStrongest:
      return "first and strongest";
    case ReturnMode::kFirstLastStrongest:
      return "first, last and strongest";
    case ReturnMode::kStrongestSecond:
      return "strongest and second strongest";
  }
  return "";
}

const char* describe(PacketFault fault) {
  switch (fault) {
    case PacketFault::kSize:
      return "not the size of the model's data packets";
    case PacketFault::kHeader:
      return "the header is not the model's";
    case PacketFault::kReturnMode:
      return "not a return mode of the model";
    case PacketFault::kAzimuth:
      return "most azimuths are above 360 degrees, or differ within a firing";
    case PacketFault::kTime:
      return "date or time of day do not exist";
  }
  return "";
}

tl::expected<Packet, PacketFault> parse_layout(const ModelInfo& info,
                                               std::span<const uint8_t> payload) {
  const auto place = find_tail(info, payload.size());
  if (!place) return tl::unexpected(PacketFault::kSize);
  if (!has_header(info, payload)) return tl::unexpected(PacketFault::kHeader);
  const uint8_t* tail = payload.data() + place->tail;
  Packet packet;
  packet.distance_unit_mm = distance_unit(info, payload);
  if (packet.distance_unit_mm == 0) return tl::unexpected(PacketFault::kHeader);
  packet.mode = static_cast<ReturnMode>(tail[info.tail.return_mode]);
  const size_t returns = number_of_returns(packet.mode);
  if (returns == 0 || returns > info.max_returns) return tl::unexpected(PacketFault::kReturnMode);
  packet.returns = static_cast<uint8_t>(returns);
  packet.sequences = static_cast<uint8_t>(info.blocks / returns);
  packet.motor_speed = read_u16(tail + info.tail.motor_speed);
  packet.factory = tail[info.tail.factory];
  packet.loop = first_loop(info, tail);
  packet.tail = static_cast<uint16_t>(place->tail);
  if (place->number) packet.number = read_u32(payload.data() + *place->number);
  return packet;
}

tl::expected<Packet, PacketFault> parse_packet(const ModelInfo& info,
                                               std::span<const uint8_t> payload) {
  auto packet = parse_layout(info, payload);
  if (!packet) return packet;
  if (!read_azimuths(info, payload, *packet)) return tl::unexpected(PacketFault::kAzimuth);
  const auto time = read_time(info.tail, payload.data() + packet->tail);
  if (!time) return tl::unexpected(PacketFault::kTime);
  packet->utc_ns = *time;
  return packet;
}

std::array<ReturnKind, kMaxReturns> return_kinds(Model model, ReturnMode mode) {
  using enum ReturnKind;
  const bool is_xt = model_info(model).protocol == 6;
  switch (mode) {
    case ReturnMode::kFirst:
      return {kFirst};
    case ReturnMode::kSecond:
      return {kSecond};
    case ReturnMode::kStrongest:
      return {kStrongest};
    case ReturnMode::kLast:
      return {kLast};
    case ReturnMode::kLastStrongest:
      return {kLast, kStrongest};
    case ReturnMode::kFirstSecond:
      return {kFirst, kSecond};
    case ReturnMode::kFirstLast:
      return is_xt ? std::array{kLast, kFirst, kFirst} : std::array{kFirst, kLast, kLast};
    case ReturnMode::kFirstStrongest:
      return {kFirst, kStrongest};
    case ReturnMode::kFirstLastStrongest:
      return {kFirst, kLast, kStrongest};
    case ReturnMode::kStrongestSecond:
      return {kStrongest, kSecondStrongest};
  }
  return {};
}

}  // namespace infuse::hesai
