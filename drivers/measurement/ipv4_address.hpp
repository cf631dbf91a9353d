#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace infuse {

/// Formats an IPv4 address in host byte order, as "10.0.0.7".
std::string address_text(uint32_t address);

/// Parses a dotted IPv4 address to host byte order; nothing if `text` is not one.
std::optional<uint32_t> parse_address(const std::string& text);

}  // namespace infuse
