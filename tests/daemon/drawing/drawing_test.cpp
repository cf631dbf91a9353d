#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "daemon/drawing/label.hpp"
#include "daemon/drawing/plan_legend.hpp"
#include "daemon/drawing/view_from_above.hpp"

namespace infuse::daemon {
namespace {

/// Relative luminance of sRGB, with a gamma of 2.2; colours are blue, green, red.
double luminance(const Colour& colour) {
  const auto linear = [](uint8_t value) { return std::pow(value / 255.0, 2.2); };
  return 0.0722 * linear(colour[0]) + 0.7152 * linear(colour[1]) + 0.2126 * linear(colour[2]);
}

// A scale without a brighter and a darker half is read by who sees no hues.
TEST(ColourScale, BrightnessAloneTellsTheValue) {
  for (int k = 0; k < 50; ++k) {
    EXPECT_GT(luminance(range_colour(2 + 1.5 * k)), luminance(range_colour(2 + 1.5 * (k + 1))));
    EXPECT_LT(luminance(fraction_colour(k / 50.0)), luminance(fraction_colour((k + 1) / 50.0)));
  }
  EXPECT_EQ(range_colour(0.5), range_colour(2));
  EXPECT_EQ(range_colour(500), range_colour(80));
}

size_t drawn_pixels(const CameraFrame& image, const Colour& colour) {
  size_t count = 0;
  for (size_t i = 0; i + 2 < image.pixels.size(); i += 3) {
    count += std::equal(colour.begin(), colour.end(), image.pixels.begin() + static_cast<long>(i));
  }
  return count;
}

TEST(Label, OutsideTheImageNothingIsDrawn) {
  CameraFrame image;
  image.width = 30;
  image.height = 10;
  image.format = PixelFormat::kBgr8;
  image.pixels.assign(image.row_bytes() * 10, 0);
  const Colour white{255, 255, 255};
  draw_label(image, -100, -100, "30 m", white);
  draw_label(image, 40, 40, "30 m", white);
  EXPECT_EQ(drawn_pixels(image, white), 0u);
  draw_label(image, 20, 0, "30 m", white);  // beyond the right edge and below
  EXPECT_GT(drawn_pixels(image, white), 0u);
}

TEST(TwoViewsFromAbove, PointsAndTheLegendHaveTheirColours) {
  const Colour red{0, 0, 255}, green{0, 255, 0};
  TwoViewsFromAbove views({"before", "after"}, {{"target", green}});
  views.draw(0, 5, 5, 0, red);
  views.draw(1, 50, 0, 0, red);  // too far away
  const CameraFrame image = views.take();
  EXPECT_EQ(drawn_pixels(image, red), 1u);
  EXPECT_GT(drawn_pixels(image, green), 100u);  // once in each view
}

TEST(PlanLegend, IsBelowThePlanWithABarOfItsLength) {
  CameraFrame image;
  image.width = 400;
  image.height = 300;
  image.format = PixelFormat::kBgr8;
  image.pixels.assign(image.row_bytes() * 300, 7);
  const CameraFrame plan = image;
  const Colour red{0, 0, 255};
  add_legend(image, {0.25, true, {{"building", red}}});
  ASSERT_GT(image.height, plan.height);
  EXPECT_EQ(image.pixels.size(), image.row_bytes() * static_cast<size_t>(image.height));
  EXPECT_TRUE(std::equal(plan.pixels.begin(), plan.pixels.end(), image.pixels.begin()));
  EXPECT_EQ(drawn_pixels(image, red), 49u);
  // A fifth of 100 m is 20 m: 80 pixels, in two rows.
  int longest = 0;
  for (int row = plan.height; row < image.height; ++row) {
    int run = 0;
    for (int column = 0; column < image.width; ++column) {
      const size_t at =
          static_cast<size_t>(row) * image.row_bytes() + static_cast<size_t>(column) * 3;
      run = image.pixels[at] < 100 && image.pixels[at + 2] < 100 ? run + 1 : 0;
      longest = std::max(longest, run);
    }
  }
  EXPECT_EQ(longest, 80);
  CameraFrame narrow = plan;
  narrow.width = 50;
  add_legend(narrow, {0.25, true, {}});
  EXPECT_EQ(narrow.height, plan.height);
}

}  // namespace
}  // namespace infuse::daemon
