#pragma once

#include <string>
#include <string_view>

namespace infuse::text {

/// Checksum of a file's bytes, 16 hexadecimal digits (FNV-1a, 64 bits): finds damage, not malice.
std::string checksum(std::string_view bytes);

}  // namespace infuse::text
