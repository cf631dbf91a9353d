#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/measurement/angles.hpp"
#include "fusion/calibration/calibrate.hpp"
#include "tests/fusion/calibration/kitti_pairs.hpp"
#include "tests/fusion/calibration/nuscenes_instant.hpp"
#include "tests/real_data.hpp"

namespace infuse::calibration {
namespace {

struct NuscenesRig {
  std::vector<Scene> scenes;  ///< one per camera
  std::vector<RigCamera> cameras;
  Eigen::Isometry3d T_refcam_lidar = Eigen::Isometry3d::Identity();  ///< as published
};

NuscenesRig read_rig(const std::filesystem::path& folder) {
  const nuscenes::Instant instant = nuscenes::read_instant(folder);
  NuscenesRig rig;
  for (const nuscenes::Shot& shot : instant.shots) {
    if (rig.cameras.empty()) rig.T_refcam_lidar = shot.T_camera_lidar;
    const geometry::CameraModel model(shot.intrinsics);
    auto scene = make_scene(instant.sweep, shot.frame,
                            {.rings = features::ring_directions(model, shot.T_camera_lidar)});
    EXPECT_TRUE(scene) << shot.name;
    if (!scene) continue;
    scene->camera = rig.cameras.size();
    scene->name = shot.name;
    rig.cameras.push_back({model, shot.T_camera_lidar * rig.T_refcam_lidar.inverse()});
    rig.scenes.push_back(std::move(*scene));
  }
  return rig;
}

/// Within a degree of the published extrinsics, or refused.
void expect_never_confidently_wrong(const CalibrationResult& result, const NuscenesRig& rig) {
  if (!result.usable()) return;
  const geometry::Vector6 off = geometry::log(result.T_refcam_lidar * rig.T_refcam_lidar.inverse());
  EXPECT_LT(off.head<3>().norm(), 1 * kDegree);
  EXPECT_LT(off.tail<3>().norm(), 0.2);
}

TEST(RealNuscenes, SixCamerasAndOneSweepTogether) {
  INFUSE_REAL_DATA_OR_SKIP(folder, "calibration/nuscenes");
  const NuscenesRig rig = read_rig(folder);
  ASSERT_EQ(rig.cameras.size(), 6U);
  for (const auto& start : kitti::draw_initial_poses(rig.T_refcam_lidar, 1 * kDegree, 0.05, 2, 3)) {
    expect_never_confidently_wrong(calibrate(rig.scenes, rig.cameras, start, {}), rig);
  }
  expect_never_confidently_wrong(calibrate(rig.scenes, rig.cameras, rig.T_refcam_lidar, {}), rig);
}

TEST(RealNuscenes, OneCameraAndOneSweepAreRefused) {
  INFUSE_REAL_DATA_OR_SKIP(folder, "calibration/nuscenes");
  NuscenesRig rig = read_rig(folder);
  rig.scenes.resize(1);
  const CalibrationResult result = calibrate(rig.scenes, rig.cameras, rig.T_refcam_lidar, {});
  EXPECT_FALSE(result.usable());
  EXPECT_THAT(result.reason, testing::HasSubstr("at least 3"));
}

}  // namespace
}  // namespace infuse::calibration
