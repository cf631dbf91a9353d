#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "drivers/measurement/error.hpp"

namespace infuse::mcap {

/// Compression of a chunk.
enum class Compression { kNone, kLz4, kZstd };

/// Name of a compression in a chunk: "", "lz4", "zstd".
std::string_view name_of(Compression compression);

/// Returns the compression of that name, or nothing.
std::optional<Compression> find_compression(std::string_view name);

/// Largest chunk that is read, decompressed, in bytes.
inline constexpr size_t kMaxChunkBytes = size_t{256} << 20;

/// Fills `out` with the `size` decompressed bytes of a chunk. The memory grows with what is
/// decompressed, not with what `size` claims. Fails if the content is damaged, is not `size` bytes
/// long, or `size` exceeds `kMaxChunkBytes`.
Result<void> decompress_chunk(Compression compression, std::span<const uint8_t> bytes,
                              uint64_t size, std::vector<uint8_t>& out);

/// Fills `out` with the compressed bytes of a chunk, in the frame formats of LZ4 and Zstandard.
Result<void> compress_chunk(Compression compression, std::span<const uint8_t> bytes,
                            std::vector<uint8_t>& out);

}  // namespace infuse::mcap
