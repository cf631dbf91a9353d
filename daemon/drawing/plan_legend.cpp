#include "daemon/drawing/plan_legend.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "daemon/drawing/label.hpp"

namespace infuse::daemon {
namespace {

constexpr uint8_t kPaper = 255;
constexpr Colour kInk{30, 30, 30};
constexpr int kNarrowest = 100;      // pixels: less has no room for a bar and its metres
constexpr int kPixelsPerDot = 1000;  // a character has 7 dots: about a hundredth of the image

/// A mark of a colour with a text behind it.
struct Entry {
  int mark_width = 0, mark_height = 0;
  Colour colour{};
  std::string text;
};

/// The largest of 1, 2, 5, 10, 20, 50, … that is not above a length.
double round_length(double length) {
  const double decade = std::pow(10, std::floor(std::log10(length)));
  return decade * (length >= 5 * decade ? 5 : length >= 2 * decade ? 2 : 1);
}

std::vector<Entry> entries_of(const PlanLegend& legend, int width, int dot) {
  const double metres = round_length(legend.metres_per_pixel * width / 5);
  std::vector<Entry> entries{{static_cast<int>(metres / legend.metres_per_pixel), 2 * dot, kInk,
                              fmt::format("{:g} m", metres)}};
  if (legend.north_up) entries.push_back({0, 0, kInk, "north up"});
  for (const ColourMeaning& meaning : legend.colours) {
    entries.push_back({7 * dot, 7 * dot, meaning.colour, meaning.name});
  }
  return entries;
}

void fill(CameraFrame& image, int left, int top, const Entry& mark) {
  const int right = std::min(left + mark.mark_width, image.width);
  for (int row = top; row < top + mark.mark_height; ++row) {
    uint8_t* const line = image.pixels.data() + static_cast<size_t>(row) * image.row_bytes();
    for (int column = left; column < right; ++column) {
      std::copy(mark.colour.begin(), mark.colour.end(),
                line + size_t{3} * static_cast<size_t>(column));
    }
  }
}

}  // namespace

void add_legend(CameraFrame& image, const PlanLegend& legend) {
  if (image.width < kNarrowest || !(legend.metres_per_pixel > 0)) return;
  const int dot =
      std::max(1, (std::max(image.width, image.height) + kPixelsPerDot / 2) / kPixelsPerDot);
  const int line_height = label_height(dot) + 3 * dot, gap = 8 * dot, behind_mark = 3 * dot;
  std::vector<std::pair<int, int>> places;  // left and line of each entry
  const std::vector<Entry> entries = entries_of(legend, image.width, dot);
  int left = gap, line = 0;
  for (const Entry& entry : entries) {
    const int width = entry.mark_width + behind_mark + label_width(entry.text, dot);
    if (left > gap && left + width + gap > image.width) left = gap, ++line;
    places.emplace_back(left, line);
    left += width + gap;
  }
  const int top = image.height + 4 * dot;
  image.height = top + (line + 1) * line_height + dot;
  image.pixels.resize(image.row_bytes() * static_cast<size_t>(image.height), kPaper);
  for (size_t i = 0; i < entries.size(); ++i) {
    const Entry& entry = entries[i];
    const int row = top + places[i].second * line_height;
    fill(image, places[i].first, row + (7 * dot - entry.mark_height) / 2, entry);
    const int behind = entry.mark_width > 0 ? entry.mark_width + behind_mark : 0;
    draw_label(image, places[i].first + behind, row, entry.text, kInk, dot);
  }
}

}  // namespace infuse::daemon
