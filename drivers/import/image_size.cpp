#include "drivers/import/image_size.hpp"

#include <array>
#include <fstream>
#include <span>

#include "drivers/measurement/big_endian.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::importers {
namespace {

using big_endian::read_u16;
using big_endian::read_u32;

constexpr int kMaxSegments = 1000;  // maximum before the first frame of a JPEG file

std::optional<ImageSize> make_size(uint32_t width, uint32_t height) {
  if (width == 0 || height == 0 || width > 65536 || height > 65536) return std::nullopt;
  return ImageSize{static_cast<int>(width), static_cast<int>(height)};
}

bool read_bytes(std::istream& in, std::span<uint8_t> bytes) {
  return in.read(reinterpret_cast<char*>(bytes.data()), std::ssize(bytes)).good();
}

// A PNG file begins with a signature, length and type of the IHDR chunk, width, height.
std::optional<ImageSize> read_png_size(std::istream& in) {
  std::array<uint8_t, 24> header{};
  if (!read_bytes(in, header)) return std::nullopt;
  if (read_u32(header, 0) != 0x89504E47 || read_u32(header, 12) != 0x49484452) return std::nullopt;
  return make_size(read_u32(header, 16), read_u32(header, 20));
}

// Start-of-frame markers are C0 … CF but for C4, C8 and CC (ITU-T T.81, table B.1).
bool is_start_of_frame(uint8_t marker) {
  return marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
}

// A segment consists of marker, length and content; a frame begins with precision, height, width.
std::optional<ImageSize> read_jpeg_size(std::istream& in) {
  std::array<uint8_t, 2> start{};
  if (!read_bytes(in, start) || read_u16(start, 0) != 0xFFD8) return std::nullopt;
  for (int k = 0; k < kMaxSegments; ++k) {
    std::array<uint8_t, 4> header{};
    if (!read_bytes(in, header) || header[0] != 0xFF || read_u16(header, 2) < 2)
      return std::nullopt;
    if (is_start_of_frame(header[1])) {
      std::array<uint8_t, 5> frame{};
      if (!read_bytes(in, frame)) return std::nullopt;
      return make_size(read_u16(frame, 3), read_u16(frame, 1));
    }
    in.seekg(read_u16(header, 2) - 2, std::ios::cur);
  }
  return std::nullopt;
}

}  // namespace

std::optional<ImageSize> read_image_size(const std::filesystem::path& path) {
  if (!text::open_regular_file(path)) return std::nullopt;
  std::ifstream in(path, std::ios::binary);
  if (const auto size = read_png_size(in)) return size;
  in.clear();
  in.seekg(0);
  return read_jpeg_size(in);
}

}  // namespace infuse::importers
