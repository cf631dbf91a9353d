#include <gtest/gtest.h>

#include "drivers/measurement/angles.hpp"
#include "fusion/calibration/calibrate.hpp"
#include "tests/fusion/calibration/kitti_pairs.hpp"
#include "tests/real_data.hpp"

namespace infuse::calibration {
namespace {

/// All pairs; read once.
const Result<kitti::Pairs>& pairs(const std::filesystem::path& folder) {
  static const Result<kitti::Pairs> read = kitti::read_pairs(folder, {});
  return read;
}

geometry::Vector6 pose_error(const CalibrationResult& result, const kitti::Pairs& truth) {
  return geometry::log(result.T_refcam_lidar * truth.T_camera_lidar.inverse());
}

TEST(RealKittiPairs, StaysAtThePublishedExtrinsics) {
  INFUSE_REAL_DATA_OR_SKIP(folder, "calibration/kitti");
  const auto& read = pairs(folder);
  ASSERT_TRUE(read) << read.error().message();
  const CalibrationResult result = calibrate(read->scenes, read->cameras, read->T_camera_lidar, {});
  EXPECT_TRUE(result.usable()) << result.reason;
  EXPECT_LT(pose_error(result, *read).head<3>().norm(), 0.2 * kDegree);
  EXPECT_LT(pose_error(result, *read).tail<3>().norm(), 0.05);
}

TEST(RealKittiPairs, FromThreeDegreesAndTenCentimetresOneOptimum) {
  INFUSE_REAL_DATA_OR_SKIP(folder, "calibration/kitti");
  const auto& read = pairs(folder);
  ASSERT_TRUE(read) << read.error().message();
  const auto starts = kitti::draw_initial_poses(read->T_camera_lidar, 3 * kDegree, 0.1, 1, 7);
  for (const Eigen::Isometry3d& start : starts) {
    const CalibrationResult result = calibrate(read->scenes, read->cameras, start, {});
    EXPECT_LT(pose_error(result, *read).head<3>().norm(), 0.2 * kDegree);
    EXPECT_LT(pose_error(result, *read).tail<3>().norm(), 0.05);
  }
}

TEST(RealKittiPairs, ImagesOfOtherScenesAreRejected) {
  INFUSE_REAL_DATA_OR_SKIP(folder, "calibration/kitti");
  const auto& read = pairs(folder);
  ASSERT_TRUE(read) << read.error().message();
  std::vector<Scene> scenes = read->scenes;
  for (size_t s = 0; s < scenes.size(); ++s) {
    scenes[s].image = read->scenes[(s + 5) % scenes.size()].image;
  }
  const auto result = calibrate(scenes, read->cameras, read->T_camera_lidar, {.restarts = 0});
  EXPECT_FALSE(result.usable());
}

}  // namespace
}  // namespace infuse::calibration
