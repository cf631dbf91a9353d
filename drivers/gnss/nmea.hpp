#pragma once

#include <string_view>
#include <tl/expected.hpp>

#include "drivers/measurement/vehicle_samples.hpp"

namespace infuse::velodyne {

/// Why a sentence says nothing.
enum class NmeaFault : uint8_t {
  kNoSentence,  ///< no '$', or no '*' behind it
  kChecksum,    ///< the two digits do not fit the characters
  kType,        ///< neither RMC nor GGA
  kField,       ///< a field that is needed is missing or is not a number
};

/// The fault in words.
const char* describe(NmeaFault fault);

/// What a sentence tells.
struct NmeaFix {
  GnssFix fix;            ///< `stamp` stays empty: it is the caller's
  bool has_date = false;  ///< a GGA has none: its `fix.utc_ns` is the time since midnight
};

/// Returns the fix of a sentence that was received at `stamp`. RMC carries date, speed and course,
/// GGA the height; each is a fix of its own. `utc_ns` is 0 if the sentence has no date.
GnssFix stamped_fix(const NmeaFix& sentence, Stamp stamp);

/// Reads the first sentence in `text`: RMC or GGA of any talker, ended by NUL, CR, LF or the end;
/// the checksum must be there and fit. What the sentence does not say is NaN or 0, as `GnssFix`
/// says.
tl::expected<NmeaFix, NmeaFault> parse_nmea(std::string_view text);

}  // namespace infuse::velodyne
