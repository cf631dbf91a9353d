#include "fusion/features/occlusion_buffer.hpp"

#include <gtest/gtest.h>

namespace infuse::features {
namespace {

TEST(OcclusionBuffer, HidesPointsBehindOthers) {
  OcclusionBuffer buffer({.cell_size = 5, .ratio = 1.1, .step = 0.3});
  buffer.reset(100, 60);
  buffer.add(52, 33, 10);
  EXPECT_FALSE(buffer.hides(52, 33, 10));
  EXPECT_FALSE(buffer.hides(54, 31, 11.2F));
  EXPECT_TRUE(buffer.hides(54, 31, 11.4F));
  EXPECT_TRUE(buffer.hides(57, 28, 20)) << "a cell beside";
  EXPECT_FALSE(buffer.hides(62, 33, 20)) << "two cells away";
}

TEST(OcclusionBuffer, ComparesWithinTheCellAloneWithoutNeighbours) {
  OcclusionBuffer buffer({.cell_size = 8, .with_neighbours = false});
  buffer.reset(100, 60);
  buffer.add(15.9F, 7, 10);
  EXPECT_TRUE(buffer.hides(8, 0, 20));
  EXPECT_FALSE(buffer.hides(16, 7, 20));
}

TEST(OcclusionBuffer, IsEmptyAfterClearAndReset) {
  OcclusionBuffer buffer({});
  buffer.reset(100, 60);
  buffer.add(0, 0, 3);
  buffer.add(99, 59, 3);
  buffer.clear_cell(0, 0);
  EXPECT_FALSE(buffer.hides(0, 0, 30));
  EXPECT_TRUE(buffer.hides(99, 59, 30));
  buffer.reset(100, 60);
  EXPECT_FALSE(buffer.hides(99, 59, 30));
}

TEST(OcclusionBuffer, AcceptsPointsOutsideOfTheImage) {
  OcclusionBuffer buffer({});
  buffer.reset(100, 60);
  buffer.add(-30, 500, 3);
  EXPECT_TRUE(buffer.hides(0, 59, 30));
}

TEST(OcclusionOptions, ReportsWhatIsWrong) {
  EXPECT_FALSE(OcclusionOptions{}.invalid());
  EXPECT_TRUE((OcclusionOptions{.cell_size = 0.5}.invalid()));
  EXPECT_TRUE((OcclusionOptions{.ratio = 0.5}.invalid()));
  EXPECT_TRUE((OcclusionOptions{.step = -1}.invalid()));
}

}  // namespace
}  // namespace infuse::features
