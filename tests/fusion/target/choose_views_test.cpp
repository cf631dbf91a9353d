#include "fusion/target/choose_views.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "fusion/target/image_coverage.hpp"

namespace infuse::target {
namespace {

/// Four corners of a square of 10 pixels.
Corners square_at(double x, double y) {
  return {{x, y}, {x + 10, y}, {x, y + 10}, {x + 10, y + 10}};
}

TEST(ChooseViews, TakesThoseThatAreFarthestApart) {
  const std::vector<Corners> views = {square_at(0, 0), square_at(1, 0), square_at(50, 0),
                                      square_at(20, 0), square_at(51, 1)};
  EXPECT_THAT(choose_views(views, 10, 5), testing::ElementsAre(0, 3, 4));
  EXPECT_THAT(choose_views(views, 2, 5), testing::ElementsAre(0, 4));
  EXPECT_THAT(choose_views(views, 10, 0), testing::SizeIs(5));
  EXPECT_TRUE(choose_views({}, 10, 5).empty());
}

TEST(ChooseViews, ABoardFoundFromItsOtherEndIsTheSameView) {
  Corners turned = square_at(0, 0);
  std::ranges::reverse(turned);
  const std::vector<Corners> views = {square_at(0, 0), turned};
  EXPECT_THAT(choose_views(views, 10, 5), testing::ElementsAre(0));
  EXPECT_THAT(choose_views(views, 10, 0), testing::ElementsAre(0, 1));
}

TEST(ImageCoverage, NamesWhatHasNoCorners) {
  const CameraIntrinsics camera{.width = 160, .height = 120, .cx = 80, .cy = 60};
  // Only the left third, and a view at the right that is not used.
  std::vector<Corners> views;
  for (const double y : {0.0, 50.0, 105.0}) views.push_back(square_at(2, y));
  views.push_back(square_at(140, 0));
  const ImageCoverage coverage = measure_coverage(camera, views, {true, true, true, false});
  EXPECT_EQ(coverage.empty_parts, "top, top right, middle, right, bottom, bottom right");
  // Cells have 10 by 10 pixels: columns 0 and 1; rows 0 and 1, 5 and 6, 10 and 11.
  EXPECT_NEAR(coverage.share, 12.0 / 192, 1e-12);
  EXPECT_NEAR(coverage.radius, std::hypot(78, 10), 1e-9);  // the middle view reaches least
  EXPECT_NEAR(coverage.corner_radius, 100, 1e-9);
  EXPECT_EQ(measure_coverage(camera, {}, {}).radius, 0);
}

}  // namespace
}  // namespace infuse::target
