#include "fusion/target/calibrate_target.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/fusion/target/made_views.hpp"

namespace infuse::target {
namespace {

/// Boards on stands: a post that leans against the board's back, 8 cm behind it and below.
std::vector<BoardSighting> on_stands(int count, const Eigen::Isometry3d& T_stated) {
  made::Draw draw(21);
  const geometry::CameraModel camera(made::intrinsics());
  const Eigen::Isometry3d T_lidar_camera = made::true_T_camera_lidar().inverse();
  std::vector<BoardSighting> sightings;
  for (int k = 0; k < count; ++k) {
    const Eigen::Isometry3d T = made::hold_up(draw, made::board());
    const auto pose =
        board_pose(camera, made::board(), made::corners_of(T, made::board(), 0.06, draw), 0.06);
    const Sweep sweep = made::scan(T_lidar_camera * T, made::board(), 0.02, draw);
    BoardSighting seen{
        pose->T_camera_board, pose->covariance,
        returns_near(sweep, T_stated.inverse() * pose->T_camera_board, made::board(), 0.3)};
    const Eigen::Vector2d half = made::board().half_size();
    for (int i = 0; i < 400; ++i) {
      const Eigen::Vector3d post(draw.even(-0.1, 0.1), draw.even(1.01, 1.4) * half.y(),
                                 draw.even(0.02, 0.04));
      seen.near.push_back(T_lidar_camera * (T * (post + made::board().middle())));
    }
    sightings.push_back(std::move(seen));
  }
  return sightings;
}

TEST(CalibrateTarget, StandsAndARoughStartDoNotTiltTheBoards) {
  const Eigen::Isometry3d truth = made::true_T_camera_lidar();
  const Eigen::Isometry3d start = made::off(truth, 0.03, 0.08);
  const auto sightings = on_stands(20, start);
  const TargetCalibration found =
      calibrate_target(sightings, made::board(), start, {.margin = 0.3}, {});
  EXPECT_TRUE(found.result.usable()) << found.result.reason;
  EXPECT_GE(found.result.used, 18);
  EXPECT_LT(made::degrees_between(found.result.T_head_lidar, truth), 0.1);
  EXPECT_LT(made::metres_between(found.result.T_head_lidar, truth), 0.005);
}

TEST(CalibrateTarget, SightingsWithoutReturnsAreListed) {
  const Eigen::Isometry3d truth = made::true_T_camera_lidar();
  auto sightings = on_stands(6, truth);
  sightings[2].near.clear();
  const TargetCalibration found = calibrate_target(sightings, made::board(), truth, {}, {});
  EXPECT_TRUE(found.result.usable()) << found.result.reason;
  ASSERT_EQ(found.result.views.size(), 6U);
  EXPECT_FALSE(found.result.views[2].used);
  EXPECT_THAT(found.missing[2], testing::HasSubstr("0 returns"));
  EXPECT_TRUE(found.missing[1].empty());
  EXPECT_GT(found.returns[1], 30U);
  EXPECT_FALSE(calibrate_target({}, made::board(), truth, {}, {}).result.usable());
}

}  // namespace
}  // namespace infuse::target
