#include "daemon/drawing/label.hpp"

#include <algorithm>

namespace infuse::daemon {
namespace {

constexpr int kGlyphColumns = 5, kGlyphRows = 7;

/// A character as rows of dots from above; the most significant of five bits is on the left.
struct Glyph {
  char character;
  std::array<uint8_t, kGlyphRows> rows;
};

/// The characters of the labels.
constexpr Glyph kGlyphs[] = {
    {'0', {14, 17, 19, 21, 25, 17, 14}}, {'1', {4, 12, 4, 4, 4, 4, 14}},
    {'2', {14, 17, 1, 2, 4, 8, 31}},     {'3', {31, 2, 4, 2, 1, 17, 14}},
    {'4', {2, 6, 10, 18, 31, 2, 2}},     {'5', {31, 16, 30, 1, 1, 17, 14}},
    {'6', {6, 8, 16, 30, 17, 17, 14}},   {'7', {31, 1, 2, 4, 8, 8, 8}},
    {'8', {14, 17, 17, 14, 17, 17, 14}}, {'9', {14, 17, 17, 15, 1, 2, 12}},
    {'.', {0, 0, 0, 0, 0, 12, 12}},      {'-', {0, 0, 0, 31, 0, 0, 0}},
    {'%', {24, 25, 2, 4, 8, 19, 3}},     {'a', {0, 0, 14, 1, 15, 17, 15}},
    {'b', {16, 16, 22, 25, 17, 17, 30}}, {'c', {0, 0, 14, 16, 16, 17, 14}},
    {'d', {1, 1, 13, 19, 17, 17, 15}},   {'e', {0, 0, 14, 17, 31, 16, 14}},
    {'f', {6, 9, 8, 28, 8, 8, 8}},       {'g', {0, 15, 17, 17, 15, 1, 14}},
    {'h', {16, 16, 22, 25, 17, 17, 17}}, {'i', {4, 0, 12, 4, 4, 4, 14}},
    {'k', {16, 16, 18, 20, 24, 20, 18}}, {'m', {0, 0, 26, 21, 21, 17, 17}},
    {'n', {0, 0, 22, 25, 17, 17, 17}},   {'o', {0, 0, 14, 17, 17, 17, 14}},
    {'l', {12, 4, 4, 4, 4, 4, 14}},      {'p', {0, 0, 30, 17, 30, 16, 16}},
    {'v', {0, 0, 17, 17, 17, 10, 4}},    {'y', {0, 0, 17, 17, 15, 1, 14}},
    {'x', {0, 0, 17, 10, 4, 10, 17}},    {'r', {0, 0, 22, 25, 16, 16, 16}},
    {'s', {0, 0, 14, 16, 14, 1, 30}},    {'t', {8, 8, 28, 8, 8, 9, 6}},
    {'u', {0, 0, 17, 17, 17, 19, 13}},   {'w', {0, 0, 17, 17, 21, 21, 10}},
};

void fill(CameraFrame& image, int left, int top, int width, int height, const Colour& colour) {
  for (int row = std::max(top, 0); row < std::min(top + height, image.height); ++row) {
    for (int column = std::max(left, 0); column < std::min(left + width, image.width); ++column) {
      std::copy(colour.begin(), colour.end(),
                image.pixels.data() + static_cast<size_t>(row) * image.row_bytes() +
                    static_cast<size_t>(column) * 3);
    }
  }
}

}  // namespace

int label_width(std::string_view text, int dot) {
  return static_cast<int>(text.size()) * (kGlyphColumns + 1) * dot;
}

int label_height(int dot) { return (kGlyphRows + 2) * dot; }

void draw_label(CameraFrame& image, int left, int top, std::string_view text, const Colour& colour,
                int dot) {
  for (const char character : text) {
    const auto* glyph =
        std::ranges::find(kGlyphs, character, [](const Glyph& one) { return one.character; });
    for (int k = 0; glyph != std::end(kGlyphs) && k < kGlyphColumns * kGlyphRows; ++k) {
      const int column = k % kGlyphColumns, row = k / kGlyphColumns;
      const int bits = glyph->rows[static_cast<size_t>(row)];
      if ((bits >> (kGlyphColumns - 1 - column) & 1) == 0) continue;
      fill(image, left + column * dot, top + row * dot, dot, dot, colour);
    }
    left += (kGlyphColumns + 1) * dot;
  }
}

}  // namespace infuse::daemon
