#include "tests/study/streetmap/single_image_pose.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/fusion/streetmap/town.hpp"

namespace infuse::streetmap {
namespace {

constexpr double kCameraHeight = 1.5, kFocalLength = 60;  // m, pixels
constexpr int kImageWidth = 120, kImageHeight = 60;

/// The camera looks ahead, 1.5 m above the vehicle origin.
Eigen::Isometry3d camera_mount() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  T.translation() << 0, kCameraHeight, 0;
  return T;
}

geometry::CameraModel camera() {
  CameraIntrinsics intrinsics;
  intrinsics.width = kImageWidth;
  intrinsics.height = kImageHeight;
  intrinsics.fx = intrinsics.fy = kFocalLength;
  intrinsics.cx = kImageWidth / 2.0 - 0.5;
  intrinsics.cy = 20 - 0.5;
  return geometry::CameraModel(intrinsics);
}

/// Image of flat ground with a colour per kind and bright kerbs and walls. Pixel (u, v) shows the
/// ground at depth f·h/(v − c_v).
ImageFeatures render_features(const SegmentMap& map, const PlanarPose& pose, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<float> noise(0, 0.05F);
  ImageFeatures features{kImageWidth, kImageHeight, {}};
  for (int v = 0; v < kImageHeight; ++v) {
    for (int u = 0; u < kImageWidth; ++u) {
      std::array<float, 5> pixel{0.9F, 0.8F, 0.7F, 0, 0};
      if (v > 20) {
        const double ahead = kFocalLength * kCameraHeight / (v - 19.5);
        const double left = -(u - (kImageWidth / 2.0 - 0.5)) / kFocalLength * ahead;
        const Eigen::Vector2d p = pose.transform({ahead, left});
        const auto kind = map.segment(map.id_at(p.x(), p.y())).kind;
        const bool line = kind == SegmentKind::kKerb || kind == SegmentKind::kWall;
        const auto kind_value = static_cast<float>(static_cast<int>(kind));
        pixel = {0.2F + 0.06F * kind_value, 0.9F - 0.07F * kind_value, line ? 0.9F : 0.3F,
                 line ? 0.8F : 0.1F, line ? 1.5F : 0};
      }
      for (size_t c = 0; c < 4; ++c) pixel[c] += noise(random);
      features.pixels.push_back(pixel);
    }
  }
  return features;
}

const town::Town& shared_town() {
  static const town::Town kTown = town::build(town::plan());
  return kTown;
}

SingleImageOptions fast_options(ImageMeasure measure) {
  SingleImageOptions options;
  options.measure = measure;
  options.lateral_step = 0.4;
  options.max_yaw = 0.2;
  options.yaw_step = 0.05;
  options.max_samples = 500;
  options.bag_count = 3;
  options.fit = {.centres = 25, .sigmas = {1.0}, .lambdas = {1e-2}};
  return options;
}

class SingleImage : public testing::TestWithParam<ImageMeasure> {};

TEST_P(SingleImage, FindsLateralOffsetAndHeading) {
  int found = 0;
  for (const double across : {-1.2, 0.0, 0.8}) {
    const PlanarPose prior{-70, -1, 0};
    const double yaw = across * 0.1 - 0.02;
    const PlanarPose truth = prior.compose({0, across, yaw});
    const SingleImagePose pose =
        locate_from_image(shared_town().map, render_features(shared_town().map, truth, 3), camera(),
                          camera_mount(), prior, fast_options(GetParam()));
    ASSERT_TRUE(pose.usable()) << pose.reason;
    EXPECT_EQ(pose.scores.size(), 9U * 11U);
    found += std::abs(pose.lateral - across) < 0.5 && std::abs(pose.yaw - yaw) < 0.06;
  }
  EXPECT_EQ(found, 3);
}

INSTANTIATE_TEST_SUITE_P(Measures, SingleImage,
                         testing::Values(ImageMeasure::kLsmi, ImageMeasure::kBlsmi,
                                         ImageMeasure::kQmi, ImageMeasure::kCorrelation,
                                         ImageMeasure::kBoundaries),
                         [](const auto& instance) { return name_of(instance.param); });

// LSCE is high if all samples share one label, and MLMI has spikes, I 3.4.2.3: weaker requirements.
TEST(SingleImageMeasures, LsceAndMlmiAreFiniteAndDependOnThePose) {
  const PlanarPose truth{-70, -1, 0};
  for (const ImageMeasure measure : {ImageMeasure::kSce, ImageMeasure::kMi}) {
    SingleImageOptions options = fast_options(measure);
    options.max_samples = 200;
    options.lateral_step = 1;
    options.yaw_step = 0.2;
    const SingleImagePose pose =
        locate_from_image(shared_town().map, render_features(shared_town().map, truth, 3), camera(),
                          camera_mount(), truth, options);
    ASSERT_TRUE(pose.usable());
    const auto [min_score, max_score] = std::minmax_element(pose.scores.begin(), pose.scores.end());
    EXPECT_TRUE(std::isfinite(*min_score) && std::isfinite(*max_score));
    EXPECT_GT(*max_score, *min_score) << name_of(measure);
  }
}

TEST(SingleImageReasons, ReportWhyThereIsNoPose) {
  const ImageFeatures seen = render_features(shared_town().map, {-70, -1, 0}, 1);
  EXPECT_STREQ(locate_from_image(shared_town().map, seen, camera(), camera_mount(), {5000, 0, 0},
                                 fast_options(ImageMeasure::kLsmi))
                   .reason,
               "the prior pose is outside the map");
  Eigen::Isometry3d upwards = camera_mount();
  upwards.linear() << 0, -1, 0, -1, 0, 0, 0, 0, 1;
  upwards.translation() << 0, 0, -kCameraHeight;
  EXPECT_FALSE(locate_from_image(shared_town().map, seen, camera(), upwards, {-70, -1, 0},
                                 fast_options(ImageMeasure::kLsmi))
                   .usable());
  ImageFeatures blank = seen;
  for (auto& pixel : blank.pixels) pixel = {0.5F, 0.5F, 0.5F, 0, 0};
  EXPECT_FALSE(locate_from_image(shared_town().map, blank, camera(), camera_mount(), {-70, -1, 0},
                                 fast_options(ImageMeasure::kBoundaries))
                   .usable());
  SingleImageOptions wrong;
  wrong.lateral_step = 0;
  EXPECT_TRUE(wrong.invalid());
  wrong = {};
  wrong.bag_count = 1000;
  EXPECT_TRUE(wrong.invalid());
  EXPECT_FALSE(SingleImageOptions().invalid());
}

}  // namespace
}  // namespace infuse::streetmap
