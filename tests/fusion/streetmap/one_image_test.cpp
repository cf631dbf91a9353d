#include "fusion/streetmap/one_image.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/fusion/streetmap/town.hpp"

namespace infuse::streetmap {
namespace {

constexpr double kHeight = 1.5, kFocal = 60;  // m, pixels
constexpr int kWidth = 120, kRows = 60;

/// The camera looks ahead from 1.5 m above the vehicle's origin.
Eigen::Isometry3d camera_mount() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  T.translation() << 0, kHeight, 0;
  return T;
}

geometry::CameraModel camera() {
  CameraIntrinsics intrinsics;
  intrinsics.width = kWidth;
  intrinsics.height = kRows;
  intrinsics.fx = intrinsics.fy = kFocal;
  intrinsics.cx = kWidth / 2.0 - 0.5;
  intrinsics.cy = 20 - 0.5;
  return geometry::CameraModel(intrinsics);
}

/// A picture of flat ground whose colour tells its kind, and bright kerbs and walls; by hand: the
/// pixel (u, v) sees the ground at depth f·h/(v − c_v) ahead.
PictureFeatures picture(const SegmentMap& map, const PlanarPose& pose, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<float> noise(0, 0.05F);
  PictureFeatures features{kWidth, kRows, {}};
  for (int v = 0; v < kRows; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      std::array<float, 5> pixel{0.9F, 0.8F, 0.7F, 0, 0};
      if (v > 20) {
        const double ahead = kFocal * kHeight / (v - 19.5);
        const double left = -(u - (kWidth / 2.0 - 0.5)) / kFocal * ahead;
        const Eigen::Vector2d p = pose.of({ahead, left});
        const auto kind = map.segment(map.id_at(p.x(), p.y())).kind;
        const bool line = kind == SegmentKind::kKerb || kind == SegmentKind::kWall;
        const auto look = static_cast<float>(static_cast<int>(kind));
        pixel = {0.2F + 0.06F * look, 0.9F - 0.07F * look, line ? 0.9F : 0.3F, line ? 0.8F : 0.1F,
                 line ? 1.5F : 0};
      }
      for (size_t c = 0; c < 4; ++c) pixel[c] += noise(random);
      features.pixels.push_back(pixel);
    }
  }
  return features;
}

const town::Town& the_town() {
  static const town::Town kTown = town::build(town::plan());
  return kTown;
}

OneImageOptions quick(ImageMeasure measure) {
  OneImageOptions options;
  options.measure = measure;
  options.across_step = 0.4;
  options.turn = 0.2;
  options.turn_step = 0.05;
  options.most_samples = 500;
  options.bags = 3;
  options.fit = {.centres = 25, .sigmas = {1.0}, .lambdas = {1e-2}};
  return options;
}

class OneImage : public testing::TestWithParam<ImageMeasure> {};

TEST_P(OneImage, FindsPlaceAndHeading) {
  int found = 0;
  for (const double across : {-1.2, 0.0, 0.8}) {
    const PlanarPose prior{-70, -1, 0};
    const double yaw = across * 0.1 - 0.02;
    const PlanarPose truth = prior.then({0, across, yaw});
    const OneImagePose pose = locate_by_picture(the_town().map, picture(the_town().map, truth, 3),
                                                camera(), camera_mount(), prior, quick(GetParam()));
    ASSERT_TRUE(pose.usable()) << pose.reason;
    EXPECT_EQ(pose.scores.size(), 9U * 11U);
    found += std::abs(pose.across - across) < 0.5 && std::abs(pose.yaw - yaw) < 0.06;
  }
  EXPECT_EQ(found, 3);
}

INSTANTIATE_TEST_SUITE_P(Measures, OneImage,
                         testing::Values(ImageMeasure::kLsmi, ImageMeasure::kBlsmi,
                                         ImageMeasure::kQmi, ImageMeasure::kCorrelation,
                                         ImageMeasure::kBoundaries),
                         [](const auto& instance) { return name(instance.param); });

// LSCE is high where all is one label, and MLMI has spikes, I 3.4.2.3: little is asked of them.
TEST(OneImageMeasures, TheSensitiveOnesAreFiniteAndDependOnThePose) {
  const PlanarPose truth{-70, -1, 0};
  for (const ImageMeasure measure : {ImageMeasure::kSce, ImageMeasure::kMi}) {
    OneImageOptions options = quick(measure);
    options.most_samples = 200;
    options.across_step = 1;
    options.turn_step = 0.2;
    const OneImagePose pose = locate_by_picture(the_town().map, picture(the_town().map, truth, 3),
                                                camera(), camera_mount(), truth, options);
    ASSERT_TRUE(pose.usable());
    const auto [least, most] = std::minmax_element(pose.scores.begin(), pose.scores.end());
    EXPECT_TRUE(std::isfinite(*least) && std::isfinite(*most));
    EXPECT_GT(*most, *least) << name(measure);
  }
}

TEST(OneImageReasons, SayWhyThereIsNoPose) {
  const PictureFeatures seen = picture(the_town().map, {-70, -1, 0}, 1);
  EXPECT_STREQ(locate_by_picture(the_town().map, seen, camera(), camera_mount(), {5000, 0, 0},
                                 quick(ImageMeasure::kLsmi))
                   .reason,
               "the prior pose is outside the map");
  Eigen::Isometry3d upwards = camera_mount();
  upwards.linear() << 0, -1, 0, -1, 0, 0, 0, 0, 1;
  upwards.translation() << 0, 0, -kHeight;
  EXPECT_FALSE(locate_by_picture(the_town().map, seen, camera(), upwards, {-70, -1, 0},
                                 quick(ImageMeasure::kLsmi))
                   .usable());
  PictureFeatures blank = seen;
  for (auto& pixel : blank.pixels) pixel = {0.5F, 0.5F, 0.5F, 0, 0};
  EXPECT_FALSE(locate_by_picture(the_town().map, blank, camera(), camera_mount(), {-70, -1, 0},
                                 quick(ImageMeasure::kBoundaries))
                   .usable());
  OneImageOptions wrong;
  wrong.across_step = 0;
  EXPECT_TRUE(wrong.invalid());
  wrong = {};
  wrong.bags = 1000;
  EXPECT_TRUE(wrong.invalid());
  EXPECT_FALSE(OneImageOptions().invalid());
}

}  // namespace
}  // namespace infuse::streetmap
