#include "drivers/recording/picture_size.hpp"

#include <array>
#include <fstream>
#include <span>

#include "drivers/recording/big_endian.hpp"

namespace infuse::recording {
namespace {

constexpr int kMostSegments = 1000;  // of a JPEG file before its first frame

std::optional<PictureSize> size_of(uint32_t width, uint32_t height) {
  if (width == 0 || height == 0 || width > 65536 || height > 65536) return std::nullopt;
  return PictureSize{static_cast<int>(width), static_cast<int>(height)};
}

bool get(std::istream& in, std::span<uint8_t> bytes) {
  return in.read(reinterpret_cast<char*>(bytes.data()), std::ssize(bytes)).good();
}

// Signature, length and type of the IHDR chunk, width, height.
std::optional<PictureSize> png_size(std::istream& in) {
  std::array<uint8_t, 24> head{};
  if (!get(in, head)) return std::nullopt;
  if (read_u32(head, 0) != 0x89504E47 || read_u32(head, 12) != 0x49484452) return std::nullopt;
  return size_of(read_u32(head, 16), read_u32(head, 20));
}

// Start-of-frame markers are C0 … CF but for C4, C8 and CC (ITU-T T.81, table B.1).
bool starts_frame(uint8_t marker) {
  return marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
}

// Segments of marker, length and content; a frame's begins with precision, height, width.
std::optional<PictureSize> jpeg_size(std::istream& in) {
  std::array<uint8_t, 2> start{};
  if (!get(in, start) || read_u16(start, 0) != 0xFFD8) return std::nullopt;
  for (int k = 0; k < kMostSegments; ++k) {
    std::array<uint8_t, 4> head{};
    if (!get(in, head) || head[0] != 0xFF || read_u16(head, 2) < 2) return std::nullopt;
    if (starts_frame(head[1])) {
      std::array<uint8_t, 5> frame{};
      if (!get(in, frame)) return std::nullopt;
      return size_of(read_u16(frame, 3), read_u16(frame, 1));
    }
    in.seekg(read_u16(head, 2) - 2, std::ios::cur);
  }
  return std::nullopt;
}

}  // namespace

std::optional<PictureSize> picture_size(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (const auto size = png_size(in)) return size;
  in.clear();
  in.seekg(0);
  return jpeg_size(in);
}

}  // namespace infuse::recording
