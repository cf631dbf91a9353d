#pragma once

#include <optional>
#include <string_view>

#include "drivers/measurement/stamp.hpp"

namespace infuse::recording {

/// The time that a line of a candump log begins with: "(1436509052.249713) …", with one to nine
/// digits of a second. Nothing where it does not.
std::optional<Stamp> parse_candump_stamp(std::string_view line);

}  // namespace infuse::recording
