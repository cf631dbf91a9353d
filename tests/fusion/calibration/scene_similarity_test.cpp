#include "fusion/calibration/scene_similarity.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/fusion/calibration/painted_world.hpp"

namespace infuse::calibration {
namespace {

/// A place as the camera sees it from so many metres farther ahead.
CameraFrame view(uint64_t world, double ahead = 0) {
  Eigen::Isometry3d T_camera_lidar = painted::true_T_camera_lidar();
  T_camera_lidar.pretranslate(Eigen::Vector3d(0, 0, -ahead));
  return painted::render_image(painted::make_world(world), painted::small_camera(), T_camera_lidar);
}

Scene scene_of(const CameraFrame& frame, size_t camera = 0) {
  Scene scene{.camera = camera};
  scene.image = compute_image_features(
      frame, {.rings = features::ring_directions(geometry::CameraModel(painted::small_camera()),
                                                 painted::true_T_camera_lidar())});
  return scene;
}

/// Strong reflections in the lowest eighth of every image.
CameraFrame with_bonnet(CameraFrame frame) {
  std::mt19937 random(1);
  for (size_t i = frame.pixels.size() * 7 / 8; i < frame.pixels.size(); ++i) {
    frame.pixels[i] = static_cast<uint8_t>(random());
  }
  return frame;
}

double effective(const Eigen::MatrixXd& similarity) {
  return effective_scenes(similarity, scene_weights(similarity));
}

TEST(SceneSimilarity, FadesWithTheWayBetweenTwoViews) {
  std::vector<Scene> scenes;
  for (const double ahead : {0.0, 0.1, 0.3, 1.0}) scenes.push_back(scene_of(view(1, ahead)));
  const Eigen::MatrixXd similarity = scene_similarity(scenes);
  EXPECT_EQ(similarity, similarity.transpose());
  EXPECT_EQ(similarity.diagonal(), Eigen::VectorXd::Ones(4));
  EXPECT_GT(similarity(0, 1), 0.8);
  EXPECT_GT(similarity(0, 2), 0.3);
  EXPECT_LT(similarity(0, 2), similarity(0, 1));
  EXPECT_LT(similarity(0, 3), similarity(0, 2));
}

TEST(SceneSimilarity, DifferentPlacesDifferEvenWithABonnetInView) {
  std::vector<Scene> scenes;
  for (const uint64_t world : {1, 2, 3}) {
    scenes.push_back(scene_of(view(world)));
    scenes.push_back(scene_of(with_bonnet(view(world))));
  }
  const Eigen::MatrixXd similarity = scene_similarity(scenes);
  for (const int a : {0, 2, 4}) {
    for (int b = 0; b < a; b += 2) {
      EXPECT_LT(similarity(a, b), 0.05);
      EXPECT_LT(similarity(a + 1, b + 1), 0.2);
    }
  }
}

TEST(SceneSimilarity, ImagesOfDifferentCamerasCountEach) {
  const std::vector<Scene> scenes{scene_of(view(1), 0), scene_of(view(1), 1)};
  EXPECT_EQ(effective(scene_similarity(scenes)), 2);
}

TEST(SceneSimilarity, ScenesWithoutImagesAreDifferent) {
  const std::vector<Scene> scenes(3);
  EXPECT_EQ(effective(scene_similarity(scenes)), 3);
  EXPECT_EQ(effective(scene_similarity({})), 0);
}

TEST(EffectiveScenes, MatchTheClosedForms) {
  EXPECT_EQ(effective(Eigen::MatrixXd::Identity(7, 7)), 7);
  EXPECT_EQ(effective(Eigen::MatrixXd::Ones(7, 7)), 1);
  Eigen::MatrixXd pairs = Eigen::MatrixXd::Identity(8, 8);
  for (int k = 0; k < 8; k += 2) pairs(k, k + 1) = pairs(k + 1, k) = 1;
  EXPECT_EQ(effective(pairs), 4);
  EXPECT_EQ(design_effect(pairs, scene_weights(pairs)), 2);
}

// Four views of one place beside four places: with weights of a half that place counts as two.
TEST(EffectiveScenes, AFrequentPlaceCountsLessOften) {
  Eigen::MatrixXd similarity = Eigen::MatrixXd::Identity(8, 8);
  similarity.topLeftCorner(4, 4).setOnes();
  const Eigen::VectorXd weights = scene_weights(similarity);
  EXPECT_EQ(weights.head(4), Eigen::VectorXd::Constant(4, 0.5));
  EXPECT_EQ(weights.tail(4), Eigen::VectorXd::Ones(4));
  // The variance of the weighted sum of unit variances is 4 + 2².
  EXPECT_DOUBLE_EQ(effective_scenes(similarity, weights), 36.0 / 8);
  EXPECT_DOUBLE_EQ(design_effect(similarity, weights), 8 / 5.0);
}

}  // namespace
}  // namespace infuse::calibration
