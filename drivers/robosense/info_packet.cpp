#include "drivers/robosense/info_packet.hpp"

#include <algorithm>
#include <string_view>

#include "drivers/measurement/big_endian.hpp"

namespace infuse::robosense {
namespace {

constexpr std::array<uint8_t, 8> kInfoMark{0xA5, 0xFF, 0x00, 0x5A, 0x11, 0x11, 0x55, 0x55};

/// A sign (0: positive) and a number of 0.01°; 0 where the memory is empty (all ones).
int read_angle(std::span<const uint8_t> payload, size_t at) {
  if (payload[at] == 0xFF) return 0;
  const int hundredths = big_endian::read_u16(payload, at + 1);
  return payload[at] == 0 ? hundredths : -hundredths;
}

std::optional<ReturnMode> read_mode(uint8_t value) {
  constexpr uint8_t kBpearlStrongest = 1, kBpearlLast = 2;  // versions 2 and 3
  if (value == kBpearlStrongest) return ReturnMode::kStrongest;
  if (value == kBpearlLast) return ReturnMode::kLast;
  const auto mode = static_cast<ReturnMode>(value);
  switch (mode) {
    case ReturnMode::kDual:
    case ReturnMode::kStrongest:
    case ReturnMode::kLast:
    case ReturnMode::kFirst:
      return mode;
  }
  return std::nullopt;
}

/// Bytes as digits of 16, without the zeros in front.
std::string digits_of(std::span<const uint8_t> bytes) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (const uint8_t byte : bytes) {
    if (text.empty() && byte == 0) continue;
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

}  // namespace

const char* name_of(TimeMode mode) {
  switch (mode) {
    case TimeMode::kGps:
      return "GPS";
    case TimeMode::kPtpE2e:
    case TimeMode::kPtpP2p:
      return "PTP";
    case TimeMode::kGptp:
      return "gPTP";
  }
  return "";
}

bool is_info_packet(std::span<const uint8_t> payload) {
  return payload.size() == kPacketSize &&
         std::equal(kInfoMark.begin(), kInfoMark.end(), payload.begin());
}

std::optional<InfoPacket> parse_info_packet(std::span<const uint8_t> payload) {
  constexpr size_t kMotorSpeed = 8, kReturnMode = 300, kTimeMode = 301, kSynchronised = 302;
  constexpr size_t kRotation = 337, kSentence = 382, kSentenceSize = 86, kElevations = 468,
                   kAzimuths = 564;
  constexpr size_t kAngleSize = 3, kSoftware = 50, kSoftwareSize = 5;
  constexpr size_t kSerialNumber = 292, kSerialNumberSize = 6;
  if (!is_info_packet(payload)) return std::nullopt;
  InfoPacket packet;
  packet.motor_speed = big_endian::read_u16(payload, kMotorSpeed);
  packet.software = digits_of(payload.subspan(kSoftware, kSoftwareSize));
  packet.serial_number = digits_of(payload.subspan(kSerialNumber, kSerialNumberSize));
  packet.mode = read_mode(payload[kReturnMode]);
  if (payload[kTimeMode] <= 3) packet.time_mode = static_cast<TimeMode>(payload[kTimeMode]);
  packet.synchronised = payload[kSynchronised] == 1 || payload[kSynchronised] == 2;
  const auto* sentence = reinterpret_cast<const char*>(payload.data() + kSentence);
  packet.sentence = gnss::parse_nmea(std::string_view(sentence, kSentenceSize));
  packet.calibration.anticlockwise = payload[kRotation] == 1;
  for (size_t channel = 0; channel < kChannels; ++channel) {
    packet.calibration.beams[channel] = {read_angle(payload, kElevations + channel * kAngleSize),
                                         read_angle(payload, kAzimuths + channel * kAngleSize)};
  }
  return packet;
}

}  // namespace infuse::robosense
