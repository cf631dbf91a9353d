#include "fusion/streetmap/draw_map.hpp"

#include <algorithm>
#include <array>

namespace infuse::streetmap {
namespace {

struct Colour {
  int r, g, b;
  int spread;  // colour difference between ids of one kind
};

Colour colour_of(SegmentKind kind) {
  switch (kind) {
    case SegmentKind::kOpenLand:
      return {235, 232, 222, 0};
    case SegmentKind::kCarriageway:
      return {110, 110, 118, 15};
    case SegmentKind::kKerb:
      return {40, 40, 40, 20};
    case SegmentKind::kSidewalk:
      return {215, 200, 160, 10};
    case SegmentKind::kFootway:
      return {225, 160, 90, 15};
    case SegmentKind::kCrossing:
      return {250, 240, 60, 5};
    case SegmentKind::kGreen:
      return {130, 190, 110, 20};
    case SegmentKind::kWater:
      return {110, 160, 225, 25};
    case SegmentKind::kPaved:
      return {190, 170, 205, 12};
    case SegmentKind::kBuilding:
      return {195, 110, 100, 25};
    case SegmentKind::kWall:
      return {115, 30, 30, 25};
    case SegmentKind::kImageRegion:
      return {150, 150, 150, 105};
    case SegmentKind::kImageLine:
      return {30, 30, 30, 30};
  }
  return {0, 0, 0, 0};
}

std::array<uint8_t, 3> bgr_of(SegmentKind kind, uint32_t id) {
  const Colour colour = colour_of(kind);
  const uint32_t hash = (id * 2654435761U) ^ ((id * 2654435761U) >> 15);
  const auto shifted = [&](int value, int byte) {
    const int step = static_cast<int>(hash >> (8 * byte) & 255U) - 128;
    return static_cast<uint8_t>(std::clamp(value + colour.spread * step / 128, 0, 255));
  };
  return {shifted(colour.b, 0), shifted(colour.g, 1), shifted(colour.r, 2)};
}

}  // namespace

std::array<uint8_t, 3> drawn_colour(SegmentKind kind) {
  const Colour colour = colour_of(kind);
  return {static_cast<uint8_t>(colour.b), static_cast<uint8_t>(colour.g),
          static_cast<uint8_t>(colour.r)};
}

CameraFrame draw_map(const SegmentMap& map, int largest) {
  CameraFrame image;
  image.format = PixelFormat::kBgr8;
  if (map.empty() || largest < 1) return image;
  const int step = (std::max(map.columns(), map.rows()) + largest - 1) / largest;
  image.width = map.columns() / step;
  image.height = map.rows() / step;
  image.pixels.resize(image.row_bytes() * static_cast<size_t>(image.height));
  std::vector<std::array<uint8_t, 3>> palette;
  for (uint32_t id = 0; id < map.segment_count(); ++id) {
    palette.push_back(bgr_of(map.segment(id).kind, id));
  }
  size_t at = 0;
  for (int y = 0; y < image.height; ++y) {
    const int row = (image.height - 1 - y) * step;
    for (int x = 0; x < image.width; ++x) {
      for (const uint8_t value : palette[map.id_of_cell(x * step, row)]) {
        image.pixels[at++] = value;
      }
    }
  }
  return image;
}

}  // namespace infuse::streetmap
