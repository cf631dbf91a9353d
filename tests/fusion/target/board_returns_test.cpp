#include "fusion/target/board_returns.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/fusion/target/made_views.hpp"

namespace infuse::target {
namespace {

using testing::HasSubstr;

/// A board held up, and what the lidar sees of it and of the wall behind.
struct Held {
  Eigen::Isometry3d T_lidar_board;
  std::vector<Eigen::Vector3d> near;
};

Held hold(made::Draw& draw, double margin = 0.25) {
  Held held{made::true_T_camera_lidar().inverse() * made::hold_up(draw, made::board()), {}};
  const Sweep sweep = made::scan(held.T_lidar_board, made::board(), 0.02, draw);
  held.near = returns_near(sweep, held.T_lidar_board, made::board(), margin);
  return held;
}

TEST(BoardReturns, FindsTheBoardBeforeAWall) {
  made::Draw draw(1);
  for (int k = 0; k < 10; ++k) {
    const Held held = hold(draw);
    const auto returns =
        board_returns(held.near, made::off(held.T_lidar_board, 0.05, 0.1), made::board(), 0.25, {});
    ASSERT_TRUE(returns) << returns.error().message();
    size_t expected = 0;
    made::for_each_beam([&](const Eigen::Vector3d& along, uint16_t, uint16_t) {
      expected +=
          made::meet(held.T_lidar_board, made::board(), Eigen::Vector3d::Zero(), along) ? 1 : 0;
    });
    EXPECT_NEAR(static_cast<double>(returns->size()), static_cast<double>(expected),
                0.03 * static_cast<double>(expected));
    for (const Eigen::Vector3d& point : *returns) {
      EXPECT_LT(std::abs((held.T_lidar_board.inverse() * point).z()), 0.1);
    }
  }
}

TEST(BoardReturns, ShrunkTheyLieInTheOutline) {
  made::Draw draw(6);
  const Held held = hold(draw);
  const auto returns = board_returns(held.near, held.T_lidar_board, made::board(), -0.02, {});
  ASSERT_TRUE(returns);
  const Eigen::Vector2d half = made::board().half_size();
  for (const Eigen::Vector3d& point : *returns) {
    const Eigen::Vector3d at = held.T_lidar_board.inverse() * point - made::board().middle();
    EXPECT_LE(std::abs(at.x()), half.x() - 0.02 + 1e-9);
    EXPECT_LE(std::abs(at.y()), half.y() - 0.02 + 1e-9);
  }
}

TEST(BoardReturns, NothingThereIsSaid) {
  made::Draw draw(1);
  const Held held = hold(draw);
  Eigen::Isometry3d behind = held.T_lidar_board;
  behind.translation().x() = -4;
  const auto nothing = board_returns(held.near, behind, made::board(), 0.25, {});
  ASSERT_FALSE(nothing);
  EXPECT_THAT(nothing.error().message(), HasSubstr("returns where the board should be"));
  EXPECT_FALSE(board_returns({}, held.T_lidar_board, made::board(), 0, {}));
  EXPECT_TRUE(returns_near(Sweep{}, held.T_lidar_board, made::board(), 1).empty());
}

TEST(BoardReturns, APlaneThatFacesElsewhereIsNoBoard) {
  made::Draw draw(1);
  const Held held = hold(draw);
  Eigen::Isometry3d turned = held.T_lidar_board;
  turned.linear() = held.T_lidar_board.linear() * Eigen::AngleAxisd(1.2, Eigen::Vector3d::UnitX());
  const auto found = board_returns(held.near, turned, made::board(), 0.15,
                                   {.margin = 0.15, .tilt = 0.1, .thickness = 0.02});
  EXPECT_FALSE(found);
}

TEST(BoardReturnsOptions, SaysWhatIsWrong) {
  EXPECT_FALSE(BoardReturnsOptions{}.invalid());
  EXPECT_THAT(*(BoardReturnsOptions{.margin = 0}.invalid()), HasSubstr("margin"));
  EXPECT_THAT(*(BoardReturnsOptions{.tilt = 2}.invalid()), HasSubstr("tilt"));
  EXPECT_THAT(*(BoardReturnsOptions{.fewest = 1}.invalid()), HasSubstr("fewest"));
}

}  // namespace
}  // namespace infuse::target
