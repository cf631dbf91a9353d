#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace infuse::streetmap {

/// A number that changes when a byte does, to find damaged files (not forged ones): the 32-byte
/// stripes' four words run through four multiplications side by side, some gigabytes a second; a
/// last stripe is filled up with zeros. `seed` chains one stretch to the next.
uint64_t checksum(std::span<const std::byte> bytes, uint64_t seed);

}  // namespace infuse::streetmap
