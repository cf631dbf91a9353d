#include "fusion/calibration/scene_similarity.hpp"

#include <gtest/gtest.h>

#include "tests/fusion/calibration/painted_world.hpp"

namespace infuse::calibration {
namespace {

Scene make_place(uint64_t world, uint64_t noise) {
  const painted::World place = painted::make_world(world);
  return *make_scene(
      painted::scan(place, noise, {.range_noise = 0.02}),
      painted::render_image(place, painted::small_camera(), painted::true_T_camera_lidar()),
      {.rings = features::ring_directions(geometry::CameraModel(painted::small_camera()),
                                          painted::true_T_camera_lidar())});
}

TEST(SceneSimilarity, DifferentPlacesDifferAndOnePlaceIsAlike) {
  const std::vector<Scene> scenes{make_place(1, 1), make_place(2, 2), make_place(3, 3),
                                  make_place(1, 4)};
  const Eigen::MatrixXd similarity = scene_similarity(scenes);
  EXPECT_EQ(similarity, similarity.transpose());
  EXPECT_EQ(similarity.diagonal(), Eigen::VectorXd::Ones(4));
  EXPECT_LT(similarity(0, 1), 0.1);
  EXPECT_LT(similarity(0, 2), 0.1);
  EXPECT_LT(similarity(1, 2), 0.1);
  EXPECT_GT(similarity(0, 3), 0.8);
  EXPECT_NEAR(effective_scenes(similarity), 3, 0.4);  // 16 / 6
}

TEST(SceneSimilarity, ImagesOfDifferentCamerasCountEach) {
  std::vector<Scene> scenes{make_place(1, 1), make_place(1, 2)};
  scenes[1].camera = 1;
  EXPECT_EQ(effective_scenes(scene_similarity(scenes)), 2);
}

TEST(SceneSimilarity, ScenesWithoutPointsOrImagesAreDifferent) {
  const std::vector<Scene> scenes(3);
  EXPECT_EQ(effective_scenes(scene_similarity(scenes)), 3);
  EXPECT_EQ(effective_scenes(scene_similarity({})), 0);
}

TEST(EffectiveScenes, MatchTheClosedForms) {
  EXPECT_EQ(effective_scenes(Eigen::MatrixXd::Identity(7, 7)), 7);
  EXPECT_EQ(effective_scenes(Eigen::MatrixXd::Ones(7, 7)), 1);
  Eigen::MatrixXd pairs = Eigen::MatrixXd::Identity(8, 8);
  for (int k = 0; k < 8; k += 2) pairs(k, k + 1) = pairs(k + 1, k) = 1;
  EXPECT_EQ(effective_scenes(pairs), 4);
  EXPECT_EQ(design_effect(pairs), 2);
}

// Four views of one place beside four places: with weights of a half that place counts as two.
TEST(EffectiveScenes, AFrequentPlaceCountsLessOften) {
  Eigen::MatrixXd similarity = Eigen::MatrixXd::Identity(8, 8);
  similarity.topLeftCorner(4, 4).setOnes();
  const Eigen::VectorXd weights = scene_weights(similarity);
  EXPECT_EQ(weights.head(4), Eigen::VectorXd::Constant(4, 0.5));
  EXPECT_EQ(weights.tail(4), Eigen::VectorXd::Ones(4));
  // The variance of the weighted sum of unit variances is 4 + 2².
  EXPECT_DOUBLE_EQ(effective_scenes(similarity), 36.0 / 8);
  EXPECT_DOUBLE_EQ(design_effect(similarity), 8 / 5.0);
}

}  // namespace
}  // namespace infuse::calibration
