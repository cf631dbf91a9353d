#pragma once

#include <string_view>
#include <tl/expected.hpp>

#include "drivers/measurement/vehicle_samples.hpp"

namespace infuse::gnss {

/// Reason why a sentence cannot be parsed.
enum class NmeaFault : uint8_t {
  kNoSentence,  ///< no '$', or no '*' after it
  kChecksum,    ///< checksum mismatch
  kType,        ///< neither RMC nor GGA
  kField,       ///< a required field is missing or not a number
};

/// Description of a fault.
const char* describe(NmeaFault fault);

/// Content of a sentence.
struct NmeaFix {
  GnssFix fix;            ///< `stamp` is left to the caller
  bool has_date = false;  ///< false for GGA: `fix.utc_ns` is the time since midnight
};

/// Returns the fix of a sentence that was received at `stamp`. RMC carries date, speed and course,
/// GGA the height; each is a fix of its own. `utc_ns` is 0 if the sentence has no date.
GnssFix stamped_fix(const NmeaFix& sentence, Stamp stamp);

/// Parses the first NMEA 0183 sentence in `text`: RMC or GGA of any talker, terminated by NUL, CR,
/// LF or the end of the text, with a correct checksum. Quantities that the sentence does not
/// contain are NaN or 0, as documented in `GnssFix`.
tl::expected<NmeaFix, NmeaFault> parse_nmea(std::string_view text);

}  // namespace infuse::gnss
