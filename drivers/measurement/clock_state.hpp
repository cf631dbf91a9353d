#pragma once

#include <cstdint>

#include "drivers/measurement/stamp.hpp"

namespace infuse {

/// How a device's clock relates to the host's, and whether it can be trusted. Plain data, a member
/// of every sweep.
struct ClockState {
  enum class Source : uint8_t {
    kNone,       ///< the data has no device clock (KITTI); stamps are the host's or synthetic
    kHost,       ///< stamps are host receive times; the device clock is not used
    kPowerUp,    ///< the device counts from power-up; mapped by the lower envelope of its transport
                 ///< delay
    kTopOfHour,  ///< the device counts from the top of the hour (UTC), plausible against the host's
                 ///< hour
    kUtc,        ///< the device's clock is UTC, set by a GNSS receiver
    kPtp,        ///< the device's clock follows a master's by PTP or gPTP
  };
  Source source = Source::kNone;
  bool trusted = false;
  Duration offset{0};   ///< host time minus device time; if the device's counter wraps, its hour is
                        ///< the one nearest to the host's time
  double skew_ppm = 0;  ///< rate error of the device's clock against the host's, parts per million;
                        ///< positive if the device's clock runs fast
  Duration jitter{0};   ///< mean of the transport delay above its lower envelope
  uint32_t jumps = 0;   ///< number of jumps of the device's clock or the host's
  const char* reason = "";  ///< static text: why the clock is not trusted; empty if it is
};

/// Description for people: what the stamps are based on, and what may be wrong.
constexpr const char* describe(ClockState::Source source) {
  switch (source) {
    case ClockState::Source::kNone:
      return "no device clock in the data";
    case ClockState::Source::kHost:
      return "host receive times; the device clock is not used";
    case ClockState::Source::kPowerUp:
      return "the device counts from power-up: nothing disciplines its clock (no PPS or GPS, or "
             "the host's own clock is off); mapped to host time by the lower envelope of its "
             "transport delay";
    case ClockState::Source::kTopOfHour:
      return "the device counts from the top of the hour";
    case ClockState::Source::kUtc:
      return "the device's clock is UTC";
    case ClockState::Source::kPtp:
      return "the device's clock is set by PTP";
  }
  return "";
}

}  // namespace infuse
