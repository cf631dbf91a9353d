#include "fusion/streetmap/map_from_image.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "fusion/geometry/plane_length.hpp"
#include "fusion/streetmap/segment_map.hpp"

namespace infuse::streetmap {
namespace {

constexpr uint32_t kUnfilled = UINT32_MAX;

/// True for each pixel of a line: its Sobel magnitude reaches the threshold.
std::vector<bool> find_lines(const CameraFrame& grey, double threshold) {
  const int w = grey.width, h = grey.height;
  const auto at = [&](int x, int y) {
    return int{grey.pixels[static_cast<size_t>(std::clamp(y, 0, h - 1)) * static_cast<size_t>(w) +
                           static_cast<size_t>(std::clamp(x, 0, w - 1))]};
  };
  std::vector<bool> lines(static_cast<size_t>(w) * static_cast<size_t>(h));
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      const int gx = at(x + 1, y - 1) + 2 * at(x + 1, y) + at(x + 1, y + 1) -
                     (at(x - 1, y - 1) + 2 * at(x - 1, y) + at(x - 1, y + 1));
      const int gy = at(x - 1, y + 1) + 2 * at(x, y + 1) + at(x + 1, y + 1) -
                     (at(x - 1, y - 1) + 2 * at(x, y - 1) + at(x + 1, y - 1));
      lines[static_cast<size_t>(y) * static_cast<size_t>(w) + static_cast<size_t>(x)] =
          geometry::plane_length(gx, gy) >= threshold;
    }
  }
  return lines;
}

/// Fills connected pixels of one kind. Lines connect diagonally too, regions do not.
class FloodFill {
 public:
  FloodFill(int width, int height)
      : width_(width),
        height_(height),
        ids_(static_cast<size_t>(width) * static_cast<size_t>(height), kUnfilled) {}

  /// Gives all pixels connected to `start` an id; returns their number.
  size_t fill(const std::vector<bool>& lines, size_t start, uint32_t id) {
    const bool line = lines[start];
    size_t count = 0;
    stack_.assign(1, start);
    ids_[start] = id;
    while (!stack_.empty()) {
      const size_t pixel = stack_.back();
      stack_.pop_back();
      ++count;
      const int x = static_cast<int>(pixel % static_cast<size_t>(width_));
      const int y = static_cast<int>(pixel / static_cast<size_t>(width_));
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          if ((dx == 0) == (dy == 0) && !(line && dx != 0)) continue;
          if (x + dx < 0 || x + dx >= width_ || y + dy < 0 || y + dy >= height_) continue;
          const size_t next = static_cast<size_t>(y + dy) * static_cast<size_t>(width_) +
                              static_cast<size_t>(x + dx);
          if (ids_[next] != kUnfilled || lines[next] != line) continue;
          ids_[next] = id;
          stack_.push_back(next);
        }
      }
    }
    return count;
  }

  std::vector<uint32_t>& ids() { return ids_; }

 private:
  int width_, height_;
  std::vector<uint32_t> ids_;
  std::vector<size_t> stack_;
};

}  // namespace

std::optional<std::string> ImageMapOptions::invalid() const {
  if (!(metres_per_pixel >= 0.02 && metres_per_pixel <= 10)) {
    return "metres_per_pixel of a map image must be between 0.02 and 10";
  }
  if (!(edge_threshold > 0 && edge_threshold <= 1442))
    return "edge_threshold of a map image must be between 0 and 1442";
  if (min_region_pixels < 1) return "min_region_pixels of a map image must be at least 1";
  return std::nullopt;
}

Result<std::vector<std::byte>> make_map_from_image(const CameraFrame& grey,
                                                   const ImageMapOptions& options,
                                                   std::string_view provenance) {
  if (const auto wrong = options.invalid()) return fail(*wrong);
  if (grey.format != PixelFormat::kGrey8 || grey.width < 3 || grey.height < 3) {
    return fail("the map image is too small, or not grey");
  }
  std::vector<bool> lines = find_lines(grey, options.edge_threshold);
  const size_t pixels = lines.size();
  // Specks first: they are text and symbols, not regions.
  FloodFill specks(grey.width, grey.height);
  std::vector<size_t> sizes;
  for (size_t i = 0; i < pixels; ++i) {
    if (specks.ids()[i] == kUnfilled) {
      sizes.push_back(specks.fill(lines, i, static_cast<uint32_t>(sizes.size())));
    }
  }
  for (size_t i = 0; i < pixels; ++i) {
    if (sizes[specks.ids()[i]] < static_cast<size_t>(options.min_region_pixels)) lines[i] = true;
  }
  FloodFill fill(grey.width, grey.height);
  std::vector<Segment> segments{Segment{}};
  for (size_t i = 0; i < pixels; ++i) {
    if (fill.ids()[i] != kUnfilled) continue;
    fill.fill(lines, i, static_cast<uint32_t>(segments.size()));
    segments.push_back({lines[i] ? SegmentKind::kImageLine : SegmentKind::kImageRegion, 0});
  }
  if (segments.size() < 3) {
    return fail("the map image has no closed regions", {}, "is it a map? try a smaller --edge");
  }
  constexpr int kTile = SegmentMap::kTileSize;
  const int columns = (grey.width + kTile - 1) / kTile, rows = (grey.height + kTile - 1) / kTile;
  MapFrame frame{.cell_size = options.metres_per_pixel};
  frame.min_corner = {-frame.cell_size * std::floor(grey.width / 2.0),
                      -frame.cell_size * std::floor(grey.height / 2.0)};
  SegmentMapWriter writer(frame, columns, rows);
  std::array<uint32_t, kTile * kTile> tile{};
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      for (int k = 0; k < kTile * kTile; ++k) {
        const int x = c * kTile + k % kTile, y = grey.height - 1 - (r * kTile + k / kTile);
        tile[static_cast<size_t>(k)] =
            x < grey.width && y >= 0 ? fill.ids()[static_cast<size_t>(y * grey.width + x)] : 0;
      }
      writer.set_tile(c, r, tile);
    }
  }
  return writer.finish(segments, provenance);
}

}  // namespace infuse::streetmap
