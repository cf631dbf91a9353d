#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>

#include "drivers/gnss/nmea.hpp"
#include "drivers/robosense/calibration.hpp"
#include "drivers/robosense/packet.hpp"

namespace infuse::robosense {

/// What sets the sensor's clock.
enum class TimeMode : uint8_t { kGps = 0, kPtpE2e = 1, kPtpP2p = 2, kGptp = 3 };

/// Content of an information packet (DIFOP), which the sensor sends once a second.
struct InfoPacket {
  uint16_t motor_speed = 0;           ///< rpm, as set
  std::string software;               ///< version of the bottom board's software: "20122202"
  std::string serial_number;          ///< twelve digits of 16
  std::optional<ReturnMode> mode;     ///< nothing: a value that is no mode
  std::optional<TimeMode> time_mode;  ///< nothing: a value that is no mode
  bool synchronised = false;          ///< the clock is set by what `time_mode` names
  tl::expected<gnss::NmeaFix, gnss::NmeaFault> sentence;  ///< last of the GNSS receiver
  Calibration calibration;                                ///< the unit's own; unused channels are 0
};

/// True if a payload has the size and the mark of an information packet.
bool is_info_packet(std::span<const uint8_t> payload);

/// Name of a time mode: "GPS", "PTP".
const char* name_of(TimeMode mode);

/// Parses a payload; nothing if it is no information packet. Source: the manuals of RS-Helios-16P,
/// 6.3 "DIFOP" and appendix B, and of RS-Bpearl, 5.3 and appendix B.
std::optional<InfoPacket> parse_info_packet(std::span<const uint8_t> payload);

}  // namespace infuse::robosense
