#pragma once

#include <optional>
#include <string_view>

#include "drivers/measurement/stamp.hpp"

namespace infuse::text {

/// Parses a stamp: seconds since the epoch ("1533226488.230547", "-0.5", "1.037359e-01"), or a UTC
/// date and time ("2018-08-02 16:14:48.230547"). Exact to the nanosecond unless written with an
/// exponent; further digits are truncated. Returns nothing if the text is malformed or out of
/// range.
std::optional<Stamp> parse_stamp(std::string_view text);

}  // namespace infuse::text
