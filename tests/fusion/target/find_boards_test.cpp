#include "fusion/target/find_boards.hpp"

#include <gtest/gtest.h>

#include "fusion/target/board_pose.hpp"
#include "tests/fusion/target/synthetic_views.hpp"

namespace infuse::target {
namespace {

Eigen::Isometry3d board_pose_at(double x, double y, double z, double turn,
                                const Eigen::Vector3d& axis) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(turn, axis.normalized()).toRotationMatrix();
  T.translation() = Eigen::Vector3d(x, y, z) - T.linear() * synthetic::board().middle();
  return T;
}

TEST(FindBoards, FindsEveryBoardWithinAThirdOfAPixel) {
  const std::vector<Eigen::Isometry3d> places = {board_pose_at(-1.0, -0.2, 4.0, 0.5, {0, 1, 0}),
                                                 board_pose_at(1.0, 0.3, 4.4, 0.4, {1, 0.3, 0})};
  const CameraFrame frame = synthetic::render_image(places, synthetic::board());
  const auto boards = find_boards(frame, synthetic::board(), 5);
  ASSERT_EQ(boards.size(), 2U);
  const geometry::CameraModel camera(synthetic::intrinsics());
  for (const Eigen::Isometry3d& T : places) {
    double best = 1e9;
    for (const Corners& corners : boards) {
      // With odd numbers of corners the board is symmetric under a half turn.
      for (const bool turned : {false, true}) {
        double worst = 0;
        for (size_t i = 0; i < corners.size(); ++i) {
          const auto pixel = camera.project(T * synthetic::board().corner(i));
          worst = std::max(worst, (*pixel - corners[turned ? corners.size() - 1 - i : i]).norm());
        }
        best = std::min(best, worst);
      }
    }
    EXPECT_LT(best, 0.33);
  }
}

TEST(FindBoards, FindsNothingInAnEmptyOrColouredImage) {
  CameraFrame frame;
  EXPECT_TRUE(find_boards(frame, synthetic::board(), 3).empty());
  frame.width = 320;
  frame.height = 240;
  frame.pixels.assign(320 * 240, 90);
  EXPECT_TRUE(find_boards(frame, synthetic::board(), 3).empty());
  frame.format = PixelFormat::kBgr8;
  frame.pixels.assign(3 * 320 * 240, 90);
  EXPECT_TRUE(find_boards(frame, synthetic::board(), 3).empty());
}

TEST(BoardPose, ExactCornersGiveTheExactPose) {
  synthetic::RandomSource random(1);
  for (int k = 0; k < 20; ++k) {
    const Eigen::Isometry3d T = synthetic::random_board_pose(random, synthetic::board());
    const auto pose =
        estimate_board_pose(geometry::CameraModel(synthetic::intrinsics()), synthetic::board(),
                            synthetic::project_corners(T, synthetic::board(), 0, random), 0.1);
    ASSERT_TRUE(pose);
    EXPECT_LT(synthetic::degrees_between(pose->T_camera_board, T), 1e-4);
    EXPECT_LT(synthetic::metres_between(pose->T_camera_board, T), 1e-5);
    EXPECT_LT(pose->rms, 1e-4);
  }
}

TEST(BoardPose, CovarianceMatchesManyNoisyImages) {
  synthetic::RandomSource random(2);
  const Eigen::Isometry3d T = synthetic::random_board_pose(random, synthetic::board());
  double squares = 0;
  for (int k = 0; k < 200; ++k) {
    const auto pose =
        estimate_board_pose(geometry::CameraModel(synthetic::intrinsics()), synthetic::board(),
                            synthetic::project_corners(T, synthetic::board(), 0.3, random), 0.3);
    ASSERT_TRUE(pose);
    const geometry::Vector6 error = geometry::log(pose->T_camera_board * T.inverse());
    squares += error.dot(pose->covariance.inverse() * error);
  }
  // 1200 degrees of freedom: 99.9 % within 1044 … 1367; the noise is never assumed smaller than
  // stated.
  EXPECT_GT(squares, 1000);
  EXPECT_LT(squares, 1367);
}

TEST(BoardPose, RandomCornersGiveNoPose) {
  synthetic::RandomSource random(4);
  const geometry::CameraModel camera(synthetic::intrinsics());
  Corners corners;
  for (size_t i = 0; i < synthetic::board().corner_count(); ++i) {
    corners.emplace_back(random.uniform(0, 1279), random.uniform(0, 959));
  }
  EXPECT_FALSE(estimate_board_pose(camera, synthetic::board(), corners, 0.1));
  EXPECT_FALSE(estimate_board_pose(camera, synthetic::board(), {}, 0.1));
}

}  // namespace
}  // namespace infuse::target
