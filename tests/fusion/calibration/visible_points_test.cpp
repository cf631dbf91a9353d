#include "fusion/calibration/visible_points.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace infuse::calibration {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr VisibilityOptions kNoOcclusion{.occlusion = {}};

/// 100 × 80 pixels, 100 pixels focal length, looking along z of the lidar.
RigCamera camera() {
  return {geometry::CameraModel(
      {.width = 100, .height = 80, .fx = 100, .fy = 100, .cx = 50, .cy = 40})};
}

/// Points in the camera's frame; the reflectivity counts them.
Scene scene(const std::vector<Eigen::Vector3f>& points) {
  Scene out;
  for (const auto& p : points) {
    out.x.push_back(p.x());
    out.y.push_back(p.y());
    out.z.push_back(p.z());
    out.lidar[index(LidarFeature::kReflectivity)].push_back(static_cast<float>(out.size() - 1));
  }
  return out;
}

std::vector<float> numbers(const VisiblePoints& points) {
  return points.lidar[index(LidarFeature::kReflectivity)];
}

VisiblePoints select(const std::vector<Scene>& scenes, const VisibilityOptions& options) {
  const std::vector<RigCamera> cameras{camera()};
  return select_visible(scenes, cameras, Eigen::Isometry3d::Identity(), options);
}

TEST(SelectVisible, KeepsPointsInsideTheImage) {
  const Scene points = scene({{0, 0, 10},       // the centre
                              {-5.05F, 0, 10},  // half a pixel beyond the left border
                              {4.85F, 0, 10},   // u = 98.5
                              {4.95F, 0, 10},   // u = 99.5, beyond the right border
                              {0, 3.85F, 10},   // v = 78.5
                              {0, 4.05F, 10},   // beyond the lower border
                              {0, 0, -10},      // behind
                              {0, 0, 0.5F}});   // too near
  EXPECT_THAT(numbers(select({points}, kNoOcclusion)), ElementsAre(0, 2, 4));
}

TEST(SelectVisible, APointBehindANearerOneIsHidden) {
  const Scene points = scene({{0, 0, 10},         // hidden by the next
                              {0.01F, 0, 5},      // 0.1 px beside it at half the depth
                              {0.3F, 0, 10},      // 3 px beside: its cell touches
                              {3, 0, 10},         // 30 px beside: free
                              {3.01F, 0, 10.9F},  // on the same surface, within ratio and step
                              {0, 1, 5.2F}});
  EXPECT_THAT(numbers(select({points}, {})), ElementsAre(1, 3, 4, 5));
  EXPECT_THAT(numbers(select({points}, kNoOcclusion)), ElementsAre(0, 1, 2, 3, 4, 5));
}

TEST(SelectVisible, AWallOccludedByAPostInTheCameraIsRemoved) {
  // Lidar and camera stand 1 m apart; the post at 4 m hides another part of the wall from each.
  std::vector<Eigen::Vector3f> points;
  for (int i = -40; i <= 40; ++i) points.push_back({0.1F * static_cast<float>(i), 0, 10});
  for (int i = -2; i <= 2; ++i) points.push_back({0.1F * static_cast<float>(i), 0, 4});
  const std::vector<Scene> scenes{scene(points)};
  const std::vector<RigCamera> cameras{camera()};
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation().x() = -1;  // the camera stands at x = 1
  const auto seen = numbers(select_visible(scenes, cameras, T, {}));
  // From (1, 0, 0) past the post's edges (±0.2, 4) to the wall: x from −2 to −1, with a cell's
  // margin.
  for (const float number : seen) {
    const float x = 0.1F * (number - 40);
    if (number > 80) continue;
    EXPECT_FALSE(x > -2.01F && x < -0.99F) << x;
  }
  EXPECT_GT(seen.size(), 55U);
}

TEST(SelectVisible, KeepsPointsVisibleUnderAllPoses) {
  const std::vector<Scene> scenes{scene({{0, 0, 10}, {4, 0, 10}, {-4, 0, 10}})};
  const std::vector<RigCamera> cameras{camera()};
  Eigen::Isometry3d left = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d right = left;
  left.translation().x() = -2;
  right.translation().x() = 2;
  EXPECT_THAT(numbers(select_visible(scenes, cameras, left, kNoOcclusion)), ElementsAre(0, 1));
  EXPECT_THAT(numbers(select_visible(scenes, cameras, std::vector{left, right}, kNoOcclusion)),
              ElementsAre(0));
}

TEST(SelectVisible, ThinsEvenlyOverAllScenes) {
  std::vector<Eigen::Vector3f> many(100, Eigen::Vector3f(0, 0, 10));
  VisibilityOptions options = kNoOcclusion;
  options.max_points = 60;
  const VisiblePoints points = select({scene(many), scene(many)}, options);
  EXPECT_EQ(points.size(), 50U);
  ASSERT_EQ(points.blocks.size(), 2U);
  EXPECT_EQ(points.blocks[0].end, 25U);
  EXPECT_EQ(numbers(points)[1], 4);
}

TEST(SelectVisible, ASceneOutOfViewHasAnEmptyBlock) {
  const VisiblePoints points =
      select({scene({{0, 0, 10}}), scene({{0, 0, -10}}), scene({{0, 0, 20}})}, {});
  ASSERT_EQ(points.blocks.size(), 3U);
  EXPECT_EQ(points.blocks[1].begin, points.blocks[1].end);
  const VisiblePoints last = select_blocks(points, std::span(points.blocks).subspan(2, 1));
  EXPECT_THAT(last.z, ElementsAre(20));
  ASSERT_EQ(last.blocks.size(), 1U);
  EXPECT_EQ(last.blocks[0].scene, 2U);
  EXPECT_THAT(last.lidar[index(LidarFeature::kDiscontinuity)], IsEmpty());
}

TEST(VisibilityOptions, SaysWhatIsWrong) {
  EXPECT_FALSE(VisibilityOptions{}.invalid());
  EXPECT_TRUE((VisibilityOptions{.min_depth = 0}.invalid()));
  EXPECT_TRUE((VisibilityOptions{.occlusion = {{.cell_size = 0.5}}}.invalid()));
  EXPECT_TRUE((VisibilityOptions{.occlusion = {{.ratio = 0.5}}}.invalid()));
  EXPECT_TRUE((VisibilityOptions{.occlusion = {{.step = -1}}}.invalid()));
}

}  // namespace
}  // namespace infuse::calibration
