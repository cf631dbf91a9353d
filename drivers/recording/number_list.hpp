#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "drivers/measurement/stamp.hpp"

namespace infuse::recording {

/// Numbers separated by blanks; nothing where something else is among them or one is not finite.
std::optional<std::vector<double>> parse_numbers(std::string_view text);

/// Seconds since the epoch as "1436509052.249713" or "1.037359e-01": exact to the nanosecond where
/// written without an exponent. Nothing where it is negative or beyond the range of a stamp.
std::optional<Stamp> parse_seconds(std::string_view text);

}  // namespace infuse::recording
