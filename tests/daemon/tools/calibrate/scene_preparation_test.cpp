#include "daemon/tools/calibrate/scene_preparation.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "daemon/drawing/calibration_images.hpp"
#include "daemon/tools/calibrate/calibration_comparison.hpp"

namespace infuse::daemon {
namespace {

/// A pair of a sweep of one ring around the lidar and an image with a pattern.
ScenePair make_pair(size_t camera, int number) {
  ScenePair pair{.name = std::to_string(number), .camera = camera};
  pair.frame.width = 64;
  pair.frame.height = 48;
  for (int i = 0; i < 64 * 48; ++i) {
    pair.frame.pixels.push_back(static_cast<uint8_t>((i * 7 + number * 31) % 256));
  }
  pair.sweep.rings = 1;
  pair.sweep.columns = 360;
  pair.sweep.resize(360);
  for (size_t i = 0; i < 360; ++i) {
    const double azimuth = M_PI / 180 * (180 - static_cast<double>(i));
    const double range = 10 + static_cast<double>(i % 20 < 10);
    pair.sweep.x[i] = static_cast<float>(range * std::cos(azimuth));
    pair.sweep.y[i] = static_cast<float>(range * std::sin(azimuth));
    pair.sweep.z[i] = 0;
    pair.sweep.range[i] = static_cast<float>(range);
    pair.sweep.reflectivity[i] = 0.01F * static_cast<float>(i % 90);
    pair.sweep.ring[i] = 0;
    pair.sweep.column[i] = static_cast<uint16_t>(i);
    pair.sweep.time_offset_ns[i] = 0;
    pair.sweep.return_kind[i] = ReturnKind::kStrongest;
  }
  return pair;
}

ScenePairs two_cameras() {
  ScenePairs pairs;
  for (const char* name : {"front", "rear"}) {
    CameraMount mount{.name = name};
    mount.intrinsics = {.width = 64, .height = 48, .fx = 60, .fy = 60, .cx = 31.5, .cy = 23.5};
    mount.T_camera_lidar = Eigen::Isometry3d::Identity();
    mount.T_camera_lidar.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
    pairs.cameras.push_back(mount);
  }
  pairs.cameras[1].T_camera_lidar.linear() << 0, 1, 0, 0, 0, -1, -1, 0, 0;
  return pairs;
}

PreparationOptions options_for(const ScenePairs& pairs) {
  PreparationOptions options;
  options.measures = {calibration::find_measure("joint"), calibration::find_measure("mi")};
  options.T_refcam_lidar = pairs.cameras.front().T_camera_lidar;
  return options;
}

ScenePairs prepare(const PreparationOptions& options, int count) {
  ScenePairs pairs = two_cameras();
  ScenePreparation preparation(options);
  for (int k = 0; k < count; ++k) {
    ScenePair pair = make_pair(static_cast<size_t>(k) % 2, k);
    const auto done = preparation.prepare(pairs, pair);
    EXPECT_TRUE(done) << done.error().message();
    pairs.pairs.push_back(std::move(pair));
  }
  return pairs;
}

TEST(ScenePreparation, LeavesOneSceneAMeasureAndNoImages) {
  ScenePairs pairs = prepare(options_for(two_cameras()), 6);
  for (const ScenePair& pair : pairs.pairs) {
    EXPECT_FALSE(pair.has_data());
    EXPECT_EQ(pair.sweep.size(), 0U);
    ASSERT_EQ(pair.scenes.size(), 2U);
  }
  const auto scenes = move_scenes(pairs, 0);
  ASSERT_EQ(scenes.size(), 6U);
  // The cameras look ahead and back: points on the other side cannot come into view.
  for (size_t k = 0; k < scenes.size(); ++k) {
    EXPECT_EQ(scenes[k].name, std::to_string(k));
    ASSERT_GT(scenes[k].size(), 50U);
    for (const float x : scenes[k].x) EXPECT_GT(k % 2 == 0 ? x : -x, 0);
  }
}

TEST(ScenePreparation, AnyHeadingKeepsAllPoints) {
  PreparationOptions options = options_for(two_cameras());
  options.kind = CalibrationKind::kAnyHeading;
  ScenePairs pairs = prepare(options, 2);
  EXPECT_EQ(pairs.pairs[0].scenes[0].size(), 360U);
}

TEST(ScenePreparation, HeldOutPairsAreThoseOfHoldOut) {
  PreparationOptions options = options_for(two_cameras());
  options.T_old = options.T_refcam_lidar;
  ScenePairs pairs = prepare(options, 8);
  const ScenePairs held_out = hold_out(pairs);
  EXPECT_EQ(held_out.pairs.size(), 4U);
  for (const ScenePair& pair : held_out.pairs) EXPECT_EQ(pair.scenes.size(), 1U);
  for (const ScenePair& pair : pairs.pairs) EXPECT_EQ(pair.scenes.size(), 2U);
}

TEST(ScenePreparation, FewPairsStayToBeDrawnSpreadEvenly) {
  PreparationOptions options = options_for(two_cameras());
  options.draw = true;
  const ScenePairs pairs = prepare(options, 50);
  size_t kept = 0;
  for (const ScenePair& pair : pairs.pairs) kept += pair.has_data() ? 1 : 0;
  EXPECT_LE(kept, 6U);
  const std::vector<size_t> drawn = choose_drawn(pairs, 3);
  ASSERT_EQ(drawn.size(), 3U);
  EXPECT_LT(drawn[0], 17U);
  EXPECT_GE(drawn[2], 30U);
  EXPECT_TRUE(choose_drawn(prepare(options_for(two_cameras()), 4), 3).empty());
}

}  // namespace
}  // namespace infuse::daemon
