#include "fusion/target/board_returns.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/fusion/target/synthetic_views.hpp"

namespace infuse::target {
namespace {

using testing::HasSubstr;

/// A board, its returns and those of the wall behind it.
struct BoardScene {
  Eigen::Isometry3d T_lidar_board;
  std::vector<BoardReturn> nearby_returns;
};

BoardScene make_scene(synthetic::RandomSource& random, double margin = 0.25) {
  BoardScene scene{synthetic::true_T_camera_lidar().inverse() *
                       synthetic::random_board_pose(random, synthetic::board()),
                   {}};
  const Sweep sweep =
      synthetic::simulate_sweep(scene.T_lidar_board, synthetic::board(), 0.02, random);
  scene.nearby_returns = crop_to_board(sweep, scene.T_lidar_board, synthetic::board(), margin);
  return scene;
}

TEST(BoardReturns, FindsTheBoardInFrontOfAWall) {
  synthetic::RandomSource random(1);
  for (int k = 0; k < 10; ++k) {
    const BoardScene scene = make_scene(random);
    const auto returns =
        find_board_returns(scene.nearby_returns, synthetic::perturb(scene.T_lidar_board, 0.05, 0.1),
                           synthetic::board(), 0.25, {});
    ASSERT_TRUE(returns) << returns.error().message();
    size_t expected = 0;
    synthetic::for_each_beam([&](const Eigen::Vector3d& along, uint16_t, uint16_t) {
      expected += synthetic::intersect(scene.T_lidar_board, synthetic::board(),
                                       Eigen::Vector3d::Zero(), along)
                      ? 1
                      : 0;
    });
    EXPECT_NEAR(static_cast<double>(returns->size()), static_cast<double>(expected),
                0.03 * static_cast<double>(expected));
    for (const auto& [point, ring, reflectivity] : *returns) {
      EXPECT_LT(std::abs((scene.T_lidar_board.inverse() * point).z()), 0.1);
    }
  }
}

TEST(BoardReturns, ShrunkReturnsLieInsideTheOutline) {
  synthetic::RandomSource random(6);
  const BoardScene scene = make_scene(random);
  const auto returns =
      find_board_returns(scene.nearby_returns, scene.T_lidar_board, synthetic::board(), -0.02, {});
  ASSERT_TRUE(returns);
  const Eigen::Vector2d half = synthetic::board().half_size();
  for (const auto& [point, ring, reflectivity] : *returns) {
    const Eigen::Vector3d at = scene.T_lidar_board.inverse() * point - synthetic::board().middle();
    EXPECT_LE(std::abs(at.x()), half.x() - 0.02 + 1e-9);
    EXPECT_LE(std::abs(at.y()), half.y() - 0.02 + 1e-9);
  }
}

TEST(BoardReturns, ReportsAMissingBoard) {
  synthetic::RandomSource random(1);
  const BoardScene scene = make_scene(random);
  Eigen::Isometry3d behind = scene.T_lidar_board;
  behind.translation().x() = -4;
  const auto nothing =
      find_board_returns(scene.nearby_returns, behind, synthetic::board(), 0.25, {});
  ASSERT_FALSE(nothing);
  EXPECT_THAT(nothing.error().message(), HasSubstr("returns at the expected place of the board"));
  EXPECT_FALSE(find_board_returns({}, scene.T_lidar_board, synthetic::board(), 0, {}));
  EXPECT_TRUE(crop_to_board(Sweep{}, scene.T_lidar_board, synthetic::board(), 1).empty());
}

TEST(BoardReturns, RejectsAPlaneOfAnotherOrientation) {
  synthetic::RandomSource random(1);
  const BoardScene scene = make_scene(random);
  Eigen::Isometry3d turned = scene.T_lidar_board;
  turned.linear() = scene.T_lidar_board.linear() * Eigen::AngleAxisd(1.2, Eigen::Vector3d::UnitX());
  const auto found = find_board_returns(scene.nearby_returns, turned, synthetic::board(), 0.15,
                                        {.margin = 0.15, .max_tilt = 0.1, .thickness = 0.02});
  EXPECT_FALSE(found);
}

TEST(BoardReturnsOptions, ReportsInvalidValues) {
  EXPECT_FALSE(BoardReturnsOptions{}.invalid());
  EXPECT_THAT(*(BoardReturnsOptions{.margin = 0}.invalid()), HasSubstr("margin"));
  EXPECT_THAT(*(BoardReturnsOptions{.max_tilt = 2}.invalid()), HasSubstr("tilt"));
  EXPECT_THAT(*(BoardReturnsOptions{.min_returns = 1}.invalid()), HasSubstr("min_returns"));
}

}  // namespace
}  // namespace infuse::target
