#include "drivers/camera/plain_png.hpp"

#include <libdeflate.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <string_view>
#include <vector>

#include "drivers/camera/prepare_frame.hpp"
#include "drivers/measurement/sweep.hpp"

namespace infuse::camera {
namespace {

constexpr size_t kSignature = 8;       // bytes
constexpr size_t kHeader = 13;         // bytes of the IHDR chunk
constexpr size_t kChunkOverhead = 12;  // length, type and checksum

uint32_t read_u32(std::span<const uint8_t> bytes, size_t at) {
  return static_cast<uint32_t>(bytes[at]) << 24 | static_cast<uint32_t>(bytes[at + 1]) << 16 |
         static_cast<uint32_t>(bytes[at + 2]) << 8 | bytes[at + 3];
}

struct Chunk {
  std::string_view type;
  std::span<const uint8_t> content;
};

// Reads the chunk at `at` and advances it. Returns false if it is damaged.
bool read_chunk(std::span<const uint8_t> file, size_t& at, Chunk& chunk) {
  if (file.size() - at < kChunkOverhead) return false;
  const size_t length = read_u32(file, at);
  if (length > file.size() - at - kChunkOverhead) return false;
  chunk.type = {reinterpret_cast<const char*>(file.data()) + at + 4, 4};
  chunk.content = file.subspan(at + 8, length);
  const uint32_t checksum = libdeflate_crc32(0, file.data() + at + 4, length + 4);
  if (checksum != read_u32(file, at + 8 + length)) return false;
  at += length + kChunkOverhead;
  return true;
}

// True for a chunk that does not change the pixels: a remark, or a statement that they are sRGB.
bool is_harmless(const Chunk& chunk) {
  constexpr uint32_t kGammaOfSrgb = 45455;
  constexpr std::string_view kHarmless[] = {"tEXt", "zTXt", "iTXt", "tIME", "pHYs", "sRGB", "cHRM"};
  if (chunk.type == "gAMA")
    return chunk.content.size() == 4 && read_u32(chunk.content, 0) == kGammaOfSrgb;
  return std::find(std::begin(kHarmless), std::end(kHarmless), chunk.type) != std::end(kHarmless);
}

uint8_t paeth(int left, int up, int corner) {
  const int estimate = left + up - corner;
  const int a = std::abs(estimate - left), b = std::abs(estimate - up),
            c = std::abs(estimate - corner);
  return static_cast<uint8_t>(a <= b && a <= c ? left : b <= c ? up : corner);
}

// Reverses the filter of a row of `size` bytes (PNG specification, chapter 9); `above` is the row
// before, zeros for the first. `step`: bytes of a pixel. Returns false for an unknown filter.
bool reverse_filter(int filter, uint8_t* row, const uint8_t* above, size_t size, size_t step) {
  const auto add = [](uint8_t& value, int more) { value = static_cast<uint8_t>(value + more); };
  switch (filter) {
    case 0:
      return true;
    case 1:
      for (size_t i = step; i < size; ++i) add(row[i], row[i - step]);
      return true;
    case 2:
      for (size_t i = 0; i < size; ++i) add(row[i], above[i]);
      return true;
    case 3:
      for (size_t i = 0; i < step; ++i) add(row[i], above[i] / 2);
      for (size_t i = step; i < size; ++i) add(row[i], (row[i - step] + above[i]) / 2);
      return true;
    case 4:
      for (size_t i = 0; i < step; ++i) add(row[i], above[i]);
      for (size_t i = step; i < size; ++i)
        add(row[i], paeth(row[i - step], above[i], above[i - step]));
      return true;
    default:
      return false;
  }
}

// `packed`: rows of a filter byte and the pixels.
bool unpack_rows(FieldVector<uint8_t>& packed, size_t step, CameraFrame& frame) {
  const size_t size = frame.row_bytes();
  const std::vector<uint8_t> zeros(size);
  const uint8_t* above = zeros.data();
  for (size_t y = 0; y < static_cast<size_t>(frame.height); ++y) {
    uint8_t* row = packed.data() + y * (size + 1) + 1;
    if (!reverse_filter(row[-1], row, above, size, step)) return false;
    above = row;
    uint8_t* out = frame.pixels.data() + y * size;
    if (step == 1) {
      std::copy(row, row + size, out);
      continue;
    }
    for (size_t i = 0; i < size; i += 3) {  // from RGB to BGR
      out[i] = row[i + 2];
      out[i + 1] = row[i + 1];
      out[i + 2] = row[i];
    }
  }
  return true;
}

}  // namespace

bool decode_plain_png(std::span<const uint8_t> file, const ImageOptions& options,
                      CameraFrame& frame) {
  if (file.size() < kSignature) return false;
  size_t at = kSignature;
  Chunk chunk;
  if (!read_chunk(file, at, chunk) || chunk.type != "IHDR" || chunk.content.size() != kHeader)
    return false;
  const std::span<const uint8_t> header = chunk.content;
  const bool colour = header[9] == 2;
  const bool plain = header[8] == 8 && (colour || header[9] == 0) && header[10] == 0 &&
                     header[11] == 0 && header[12] == 0;
  if (!plain || (colour && options.grey)) return false;

  FieldVector<uint8_t> compressed;
  compressed.reserve(file.size());
  do {
    if (!read_chunk(file, at, chunk)) return false;
    if (chunk.type == "IDAT") {
      compressed.insert(compressed.end(), chunk.content.begin(), chunk.content.end());
    } else if (chunk.type != "IEND" && !is_harmless(chunk)) {
      return false;
    }
  } while (chunk.type != "IEND");
  if (!prepare_frame(read_u32(header, 0), read_u32(header, 4), colour, options, frame))
    return false;

  const size_t step = colour ? 3 : 1;
  FieldVector<uint8_t> packed((frame.row_bytes() + 1) * static_cast<size_t>(frame.height));
  const std::unique_ptr<libdeflate_decompressor, void (*)(libdeflate_decompressor*)> decompressor(
      libdeflate_alloc_decompressor(), &libdeflate_free_decompressor);
  return decompressor != nullptr &&
         libdeflate_zlib_decompress(decompressor.get(), compressed.data(), compressed.size(),
                                    packed.data(), packed.size(), nullptr) == LIBDEFLATE_SUCCESS &&
         unpack_rows(packed, step, frame);
}

}  // namespace infuse::camera
