#pragma once

#include <cstdio>

namespace infuse::recording {

/// The command that unpacks a file compressed in a way that is not read here ("unxz"); null: it is
/// none. The file's position must be its beginning, and is again.
const char* unknown_compression(FILE* file);

/// Returns a file that reads the content of `file` decompressed, if that begins like a gzip or zstd
/// file, else `file` itself. Takes ownership: closing the result closes `file`. Streams; memory is
/// bounded by zstd's window, at most 128 MiB. Damaged content ends with a read error (EIO), content
/// that is cut short with the end of the file. Returns null, and closes `file`, if there is no
/// memory.
FILE* decompress(FILE* file);

}  // namespace infuse::recording
