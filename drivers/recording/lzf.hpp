#pragma once

#include <cstdint>
#include <span>

namespace infuse::recording {

/// Decompresses LZF data (Marc Lehmann's liblzf): a control byte n below 32 precedes n + 1 literal
/// bytes; any other refers back by at most 8 KiB. Returns false if the data does not decompress to
/// exactly `out.size()` bytes; the content of `out` is then undefined.
bool decompress_lzf(std::span<const uint8_t> compressed, std::span<uint8_t> out);

}  // namespace infuse::recording
