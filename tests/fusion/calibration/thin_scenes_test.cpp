#include "fusion/calibration/thin_scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace infuse::calibration {
namespace {

/// 100 × 80 pixels, 100 pixels focal length, looking along z of the lidar.
const std::vector<RigCamera> kCameras{{geometry::CameraModel(
    {.width = 100, .height = 80, .fx = 100, .fy = 100, .cx = 50, .cy = 40})}};

constexpr size_t kWallColumns = 50, kWallRows = 40;

/// Wall 10 m in front of the camera, a point every two pixels, every eighth of them near a depth
/// edge; and one point behind the camera. The reflectivity counts them.
Scene wall() {
  Scene scene;
  std::vector<float>& edge = scene.lidar[index(LidarFeature::kDiscontinuity)];
  for (size_t column = 0; column < kWallColumns; ++column) {
    for (size_t row = 0; row < kWallRows; ++row) {
      scene.x.push_back((2 * static_cast<float>(column) - 49) / 10);
      scene.y.push_back((2 * static_cast<float>(row) - 39) / 10);
      scene.z.push_back(10);
      edge.push_back(scene.size() % 8 == 0 ? 1 : std::nanf(""));
    }
  }
  scene.x.push_back(0);
  scene.y.push_back(0);
  scene.z.push_back(-10);
  edge.push_back(1);
  for (size_t i = 0; i < scene.size(); ++i) {
    scene.lidar[index(LidarFeature::kReflectivity)].push_back(static_cast<float>(i));
  }
  return scene;
}

Scene thin(size_t points, bool edges_stay) {
  const std::vector<Scene> scenes{wall()};
  return thin_scenes(scenes, kCameras, Eigen::Isometry3d::Identity(), 0.05, points, edges_stay)
      .front();
}

struct Count {
  size_t near = 0, others = 0;
};

Count count(const Scene& scene) {
  Count all;
  for (const float edge : scene.lidar[index(LidarFeature::kDiscontinuity)]) {
    ++(std::isnan(edge) ? all.others : all.near);
  }
  return all;
}

TEST(ThinScenes, KeepsEveryPointInViewOnceIfTheLimitAllows) {
  const Scene scene = thin(1'000'000, false);
  const auto& number = scene.lidar[index(LidarFeature::kReflectivity)];
  EXPECT_EQ(scene.size(), kWallColumns * kWallRows) << "all but the one behind";
  EXPECT_EQ(std::set<float>(number.begin(), number.end()).size(), scene.size());
}

TEST(ThinScenes, EdgesAreKeptFourTimesAsOften) {
  const Count before = count(thin(1'000'000, false));
  const Count after = count(thin(300, false));
  const double near = static_cast<double>(after.near) / static_cast<double>(before.near);
  const double others = static_cast<double>(after.others) / static_cast<double>(before.others);
  EXPECT_NEAR(static_cast<double>(after.near + after.others), 300, 30);
  EXPECT_NEAR(near / others, 4, 1);
}

TEST(ThinScenes, TheLimitCountsOtherPointsIfAllEdgesAreKept) {
  const Count before = count(thin(1'000'000, true));
  const Count after = count(thin(500, true));
  EXPECT_EQ(after.near, before.near);
  EXPECT_NEAR(static_cast<double>(after.others), 500, 5);
}

TEST(ThinScenes, AWeightIsTheShareOfAScenesPoints) {
  const std::vector<Scene> scenes{wall(), wall()};
  const auto thinned = thin_scenes(scenes, kCameras, Eigen::Isometry3d::Identity(), 0.05, 500, true,
                                   Eigen::Vector2d(1, 0.25));
  const Count full = count(thinned[0]), quarter = count(thinned[1]);
  EXPECT_EQ(full.near, count(thin(1'000'000, true)).near);
  EXPECT_NEAR(static_cast<double>(quarter.near) / static_cast<double>(full.near), 0.25, 0.02);
  EXPECT_NEAR(static_cast<double>(quarter.others) / static_cast<double>(full.others), 0.25, 0.02);
  EXPECT_NEAR(static_cast<double>(full.others + quarter.others), 500, 5);
  // Without a limit nothing else is left out, near edges as elsewhere.
  const auto all = thin_scenes(scenes, kCameras, Eigen::Isometry3d::Identity(), 0.05, 1'000'000,
                               false, Eigen::Vector2d(1, 0.25));
  EXPECT_NEAR(static_cast<double>(count(all[1]).near), 0.25 * static_cast<double>(full.near), 2);
}

TEST(ThinScenes, PointsComeStripByStripFromTheTop) {
  const Scene scene = thin(700, true);
  // A strip is 8 pixels high, 0.8 m on the wall.
  for (size_t i = 1; i < scene.size(); ++i) {
    EXPECT_LT(scene.y[i - 1], scene.y[i] + 0.8F) << i;
  }
}

}  // namespace
}  // namespace infuse::calibration
