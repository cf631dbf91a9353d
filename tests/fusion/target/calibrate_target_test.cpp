#include "fusion/target/calibrate_target.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/fusion/target/synthetic_views.hpp"

namespace infuse::target {
namespace {

/// Boards on stands: a post leans against the back of the board, 8 cm behind and below it.
std::vector<BoardObservation> make_boards_on_stands(int count, const Eigen::Isometry3d& T_stated) {
  synthetic::RandomSource random(21);
  const geometry::CameraModel camera(synthetic::intrinsics());
  const Eigen::Isometry3d T_lidar_camera = synthetic::true_T_camera_lidar().inverse();
  std::vector<BoardObservation> observations;
  for (int k = 0; k < count; ++k) {
    const Eigen::Isometry3d T = synthetic::random_board_pose(random, synthetic::board());
    const auto pose =
        estimate_board_pose(camera, synthetic::board(),
                            synthetic::project_corners(T, synthetic::board(), 0.06, random), 0.06);
    const Sweep sweep =
        synthetic::simulate_sweep(T_lidar_camera * T, synthetic::board(), 0.02, random);
    BoardObservation observation{
        pose->T_camera_board, pose->covariance,
        crop_to_board(sweep, T_stated.inverse() * pose->T_camera_board, synthetic::board(), 0.3)};
    const Eigen::Vector2d half = synthetic::board().half_size();
    for (int i = 0; i < 400; ++i) {
      const Eigen::Vector3d post(random.uniform(-0.1, 0.1), random.uniform(1.01, 1.4) * half.y(),
                                 random.uniform(0.02, 0.04));
      observation.nearby_returns.push_back(
          {T_lidar_camera * (T * (post + synthetic::board().middle())),
           static_cast<uint16_t>(i % 64), 0.5});
    }
    observations.push_back(std::move(observation));
  }
  return observations;
}

TEST(CalibrateTarget, IsRobustToStandsAndARoughInitialGuess) {
  const Eigen::Isometry3d truth = synthetic::true_T_camera_lidar();
  const Eigen::Isometry3d initial_guess = synthetic::perturb(truth, 0.03, 0.08);
  const auto observations = make_boards_on_stands(20, initial_guess);
  const TargetCalibration found =
      calibrate_target(observations, synthetic::board(), initial_guess, {.margin = 0.3}, {});
  EXPECT_TRUE(found.result.usable()) << found.result.reason;
  EXPECT_GE(found.result.used, 18);
  EXPECT_LT(synthetic::degrees_between(found.result.T_refcam_lidar, truth), 0.1);
  EXPECT_LT(synthetic::metres_between(found.result.T_refcam_lidar, truth), 0.01);
}

TEST(CalibrateTarget, ObservationsWithoutReturnsAreListed) {
  const Eigen::Isometry3d truth = synthetic::true_T_camera_lidar();
  auto observations = make_boards_on_stands(16, truth);
  observations[2].nearby_returns.clear();
  const TargetCalibration found = calibrate_target(observations, synthetic::board(), truth, {}, {});
  EXPECT_TRUE(found.result.usable()) << found.result.reason;
  ASSERT_EQ(found.result.views.size(), 16U);
  EXPECT_FALSE(found.result.views[2].used);
  EXPECT_THAT(found.reasons[2], testing::HasSubstr("0 returns"));
  EXPECT_TRUE(found.reasons[1].empty());
  EXPECT_GT(found.return_counts[1], 30U);
  EXPECT_FALSE(calibrate_target({}, synthetic::board(), truth, {}, {}).result.usable());
}

}  // namespace
}  // namespace infuse::target
