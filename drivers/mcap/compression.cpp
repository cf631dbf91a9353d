#include "drivers/mcap/compression.hpp"

#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <memory>

namespace infuse::mcap {
namespace {

constexpr size_t kGrowth = 1 << 20;
constexpr int kMaxWindowLog = 27;  // 128 MiB

struct FreeLz4 {
  void operator()(LZ4F_dctx* context) const { LZ4F_freeDecompressionContext(context); }
};
struct FreeZstd {
  void operator()(ZSTD_DStream* stream) const { ZSTD_freeDStream(stream); }
};

// Decompresses with `step(in, in_size, out, out_size)`, which sets both sizes to what it has used
// and returns false if the content is damaged. Returns false unless `out` becomes `size` bytes.
template <class Step>
bool decompress_stream(std::span<const uint8_t> bytes, size_t size, std::vector<uint8_t>& out,
                       Step step) {
  size_t done = 0;
  while (true) {
    if (done == out.size() && done < size) out.resize(std::min(size, 2 * done + kGrowth));
    size_t taken = bytes.size();
    size_t made = out.size() - done;
    if (!step(bytes.data(), taken, out.data() + done, made)) return false;
    bytes = bytes.subspan(taken);
    done += made;
    if (taken == 0 && made == 0) break;
  }
  return done == size && bytes.empty();
}

bool decompress_lz4(std::span<const uint8_t> bytes, size_t size, std::vector<uint8_t>& out) {
  LZ4F_dctx* created = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&created, LZ4F_VERSION)) != 0) return false;
  const std::unique_ptr<LZ4F_dctx, FreeLz4> context(created);
  return decompress_stream(
      bytes, size, out, [&](const uint8_t* in, size_t& taken, uint8_t* to, size_t& made) {
        return LZ4F_isError(LZ4F_decompress(context.get(), to, &made, in, &taken, nullptr)) == 0;
      });
}

bool decompress_zstd(std::span<const uint8_t> bytes, size_t size, std::vector<uint8_t>& out) {
  const std::unique_ptr<ZSTD_DStream, FreeZstd> stream(ZSTD_createDStream());
  if (!stream) return false;
  ZSTD_DCtx_setParameter(stream.get(), ZSTD_d_windowLogMax, kMaxWindowLog);
  return decompress_stream(
      bytes, size, out, [&](const uint8_t* in, size_t& taken, uint8_t* to, size_t& made) {
        ZSTD_inBuffer input{in, taken, 0};
        ZSTD_outBuffer output{to, made, 0};
        const size_t state = ZSTD_decompressStream(stream.get(), &output, &input);
        taken = input.pos;
        made = output.pos;
        return ZSTD_isError(state) == 0;
      });
}

}  // namespace

std::string_view name_of(Compression compression) {
  switch (compression) {
    case Compression::kNone:
      return "";
    case Compression::kLz4:
      return "lz4";
    case Compression::kZstd:
      return "zstd";
  }
  return "";
}

std::optional<Compression> find_compression(std::string_view name) {
  for (const auto compression : {Compression::kNone, Compression::kLz4, Compression::kZstd}) {
    if (name == name_of(compression)) return compression;
  }
  return std::nullopt;
}

Result<void> decompress_chunk(Compression compression, std::span<const uint8_t> bytes,
                              uint64_t size, std::vector<uint8_t>& out) {
  if (size > kMaxChunkBytes) return fail("is larger than 256 MiB");
  out.clear();
  const auto length = static_cast<size_t>(size);
  bool sound = false;
  switch (compression) {
    case Compression::kNone:
      sound = bytes.size() == length;
      out.assign(bytes.begin(), bytes.end());
      break;
    case Compression::kLz4:
      sound = decompress_lz4(bytes, length, out);
      break;
    case Compression::kZstd:
      sound = decompress_zstd(bytes, length, out);
      break;
  }
  if (!sound) return fail("cannot be decompressed");
  return {};
}

Result<void> compress_chunk(Compression compression, std::span<const uint8_t> bytes,
                            std::vector<uint8_t>& out) {
  switch (compression) {
    case Compression::kNone:
      out.assign(bytes.begin(), bytes.end());
      return {};
    case Compression::kLz4: {
      out.resize(LZ4F_compressFrameBound(bytes.size(), nullptr));
      const size_t length =
          LZ4F_compressFrame(out.data(), out.size(), bytes.data(), bytes.size(), nullptr);
      if (LZ4F_isError(length) != 0) return fail("cannot be compressed");
      out.resize(length);
      return {};
    }
    case Compression::kZstd: {
      constexpr int kLevel = 1;
      out.resize(ZSTD_compressBound(bytes.size()));
      const size_t length =
          ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), kLevel);
      if (ZSTD_isError(length) != 0) return fail("cannot be compressed");
      out.resize(length);
      return {};
    }
  }
  return fail("has an unknown compression");
}

}  // namespace infuse::mcap
