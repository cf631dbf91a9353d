#include "fusion/calibration/scene_images.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "fusion/features/local_contrast.hpp"

namespace infuse::calibration {
namespace {

PerImageFeature<features::Plane> waves() {
  PerImageFeature<features::Plane> image;
  for (const ImageFeature feature : {ImageFeature::kLocalGrey, ImageFeature::kEdge}) {
    features::Plane& plane = image[index(feature)];
    plane.width = 200;
    plane.height = 150;
    for (int v = 0; v < plane.height; ++v) {
      for (int u = 0; u < plane.width; ++u) {
        plane.values.push_back(
            static_cast<float>(0.5 + 0.4 * std::sin(0.05 * u + 0.3) * std::cos(0.06 * v)));
      }
    }
  }
  return image;
}

constexpr PerImageFeature<bool> kAll{true, true, true, true, true, true, true};

TEST(CompactPlane, RoundsToEightBits) {
  features::Plane plane{.width = 5, .height = 1, .values = {0.0F, 1.0F, 0.3F, -0.1F, 1.2F}};
  const CompactPlane compact = compact_plane(plane);
  EXPECT_EQ(compact.value(0), 0.0F);
  EXPECT_EQ(compact.value(1), 1.0F);
  EXPECT_NEAR(compact.value(2), 0.3, 0.5 / 255 + 1e-7);
  EXPECT_EQ(compact.value(3), 0.0F);
  EXPECT_EQ(compact.value(4), 1.0F);
  // Grey levels are exact.
  plane.values = {17.0F / 255, 200.0F / 255, 1.0F / 255, 254.0F / 255, 128.0F / 255};
  const CompactPlane grey = compact_plane(plane);
  for (size_t i = 0; i < 5; ++i) EXPECT_FLOAT_EQ(grey.value(i), plane.values[i]);
}

TEST(SceneImages, HaveTheWantedFeaturesAtEveryBlur) {
  const auto image = waves();
  PerImageFeature<bool> wanted{};
  wanted[index(ImageFeature::kEdge)] = true;
  const std::vector<double> sigmas{4, 1, 4};
  const SceneImages images(image, wanted, sigmas);
  EXPECT_EQ(images.at(2), nullptr);
  for (const double sigma : {1.0, 4.0}) {
    const SceneImages::Level level = images.at(sigma);
    ASSERT_NE(level, nullptr);
    EXPECT_TRUE((*level)[index(ImageFeature::kLocalGrey)].values.empty());
    const CompactPlane& edge = (*level)[index(ImageFeature::kEdge)];
    EXPECT_EQ(edge.step, sigma < 2 ? 1 : 4);
    ASSERT_FALSE(edge.values.empty());
  }
}

TEST(SceneImages, AreTheSameFromFinerLevelsOrAlone) {
  const auto image = waves();
  const std::vector<double> both{2, 8};
  const SceneImages chained(image, kAll, both);
  const SceneImages alone(image, kAll, std::span(both).last(1));
  for (const ImageFeature feature : {ImageFeature::kLocalGrey, ImageFeature::kEdge}) {
    const CompactPlane& a = (*chained.at(8))[index(feature)];
    const CompactPlane& b = (*alone.at(8))[index(feature)];
    ASSERT_EQ(a.step, b.step);
    ASSERT_EQ(a.values.size(), b.values.size());
    for (size_t i = 0; i < a.values.size(); ++i) EXPECT_NEAR(a.value(i), b.value(i), 0.01);
  }
}

TEST(SceneImages, LocalGreyIsThatOfTheBlurredGrey) {
  const auto image = waves();
  const double sigma = 2;
  const SceneImages images(image, kAll, std::span(&sigma, 1));
  const features::Plane expected = features::normalize_local_contrast(
      features::blurred(image[index(ImageFeature::kLocalGrey)], sigma, 2), 16, 2.0 / 255);
  const CompactPlane& found = (*images.at(sigma))[index(ImageFeature::kLocalGrey)];
  ASSERT_EQ(found.values.size(), expected.values.size());
  for (size_t i = 0; i < expected.values.size(); ++i) {
    EXPECT_NEAR(found.value(i), expected.values[i], 0.5 / 255 + 1e-5);
  }
}

}  // namespace
}  // namespace infuse::calibration
