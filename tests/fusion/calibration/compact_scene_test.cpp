#include "fusion/calibration/compact_scene.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "fusion/calibration/calibrate.hpp"
#include "fusion/calibration/named_measures.hpp"
#include "fusion/calibration/scene_similarity.hpp"
#include "tests/fusion/calibration/painted_world.hpp"

namespace infuse::calibration {
namespace {

/// Eight scenes of a lidar that sees far more than the camera.
const painted::Drive& wide_drive() {
  static const painted::Drive drive =
      painted::make_drive(8, 1, {.columns = 1201, .half_width = 120});
  return drive;
}

std::vector<Scene> compacted(const CalibrateOptions& options, const Eigen::Isometry3d& T) {
  CompactOptions compact{.blurs = image_blurs(options),
                         .margin = options.screen.half_width * std::sqrt(3.0)};
  compact.image = compared_image_features(named_measures().front().terms);
  std::vector<Scene> scenes = wide_drive().scenes;
  for (Scene& scene : scenes) compact_scene(scene, wide_drive().cameras.front(), T, compact);
  return scenes;
}

TEST(CompactScene, ReleasesImagesAndPointsOutOfView) {
  const auto scenes = compacted({}, wide_drive().T_camera_lidar);
  for (size_t s = 0; s < scenes.size(); ++s) {
    for (const features::Plane& plane : scenes[s].image) EXPECT_TRUE(plane.values.empty());
    EXPECT_LT(scenes[s].size(), wide_drive().scenes[s].size() * 3 / 4);
    EXPECT_EQ(scenes[s].name, wide_drive().scenes[s].name);
  }
}

TEST(CompactScene, TheCalibrationIsTheSame) {
  const painted::Drive& drive = wide_drive();
  geometry::Vector6 off;
  off << 0.01, -0.015, 0.008, 0.03, -0.02, 0.04;
  const Eigen::Isometry3d initial = geometry::exp(off) * drive.T_camera_lidar;
  const CalibrateOptions options{.restarts = 2};
  const CalibrationResult all = calibrate(drive.scenes, drive.cameras, initial, options);
  const CalibrationResult compact =
      calibrate(compacted(options, initial), drive.cameras, initial, options);
  EXPECT_EQ(all.T_refcam_lidar.matrix(), compact.T_refcam_lidar.matrix());
  EXPECT_EQ(all.covariance(), compact.covariance());
  EXPECT_EQ(all.reason, compact.reason);
}

TEST(CompactScene, TheSimilarityIsThatOfTheWholeScene) {
  EXPECT_EQ(scene_similarity(compacted({}, wide_drive().T_camera_lidar)),
            scene_similarity(wide_drive().scenes));
}

TEST(CompactScene, OtherBlursAreAnError) {
  const auto scenes = compacted({}, wide_drive().T_camera_lidar);
  EXPECT_THROW(BlurredImages(scenes, wide_drive().cameras, named_measures().front().terms,
                             ImageBlur::in_angle(1.7)),
               std::logic_error);
}

}  // namespace
}  // namespace infuse::calibration
