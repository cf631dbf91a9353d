#pragma once

#include <cstdint>
#include <span>

namespace infuse::recording {

/// Unpacks what Marc Lehmann's LZF has packed: a byte below 32 is followed by that many and one
/// bytes as they are, any other refers back to at most 8 KiB before. False where the packed bytes
/// do not give exactly `out`; its content is then of no use.
bool decompress_lzf(std::span<const uint8_t> packed, std::span<uint8_t> out);

}  // namespace infuse::recording
