#include "fusion/places/image_descriptor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace infuse::places {
namespace {

constexpr int kWidth = 64, kHeight = 32;

/// Coarse noise on a wide canvas, cut out at `left`; brightness gain · value + offset.
std::vector<uint8_t> cut_out(unsigned seed, int left, double gain = 1, double offset = 0) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> grey(20, 120);
  std::vector<double> blocks(32 * 16);
  for (double& block : blocks) block = grey(random);
  std::vector<uint8_t> out;
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      const auto block = static_cast<size_t>(row / 5 * 32 + (left + column) / 5);
      out.push_back(static_cast<uint8_t>(gain * blocks[block] + offset));
    }
  }
  return out;
}

std::vector<ImageDescriptor> describe_all(int left, double gain, double offset) {
  std::vector<ImageDescriptor> drive;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    drive.push_back(describe_image(cut_out(seed, left, gain, offset), kWidth, kHeight));
  }
  remove_common_view(drive);
  return drive;
}

TEST(ImageDescriptor, LightAndAStepAsideChangeItLessThanThePlace) {
  const auto map = describe_all(8, 1, 0), query = describe_all(12, 1.8, 10);
  for (size_t i = 0; i < map.size(); ++i) {
    const double same = similarity(query[i], map[i]);
    EXPECT_GT(same, 0.7) << i;
    EXPECT_LT(similarity(query[i], map[i], 0), same - 0.15)
        << i;  // without the shift it is another view
    for (size_t j = 0; j < map.size(); ++j) {
      if (j == i) continue;
      EXPECT_LT(similarity(query[i], map[j]), same - 0.3) << i << " " << j;
    }
  }
}

TEST(ImageDescriptor, AVerticalEdgeHasOneOrientation) {
  std::vector<uint8_t> pixels;
  for (int i = 0; i < 64; ++i) pixels.push_back(i % 8 < 4 ? 0 : 200);
  const ImageDescriptor edge = describe_image(pixels, 8, 8);
  ASSERT_EQ(edge.values.size(), 8U);
  EXPECT_GT(edge.values[0], 0.99F);
  for (size_t bin = 1; bin < 8; ++bin) EXPECT_EQ(edge.values[bin], 0) << bin;
}

TEST(ImageDescriptor, SmallAndUnequalImagesAreNotSimilar) {
  const std::vector<uint8_t> pixels(kWidth * kHeight, 7);
  const ImageDescriptor none = describe_image(pixels, 4, 4);
  EXPECT_TRUE(none.values.empty());
  EXPECT_EQ(similarity(none, describe_image(pixels, kWidth, kHeight)), -1);
  EXPECT_EQ(similarity(none, none), -1);
}

TEST(DescribeContrast, DoesNotDependOnBrightnessAndContrast) {
  const auto pixels = cut_out(1, 5), brighter = cut_out(1, 5, 1.5, 40);
  std::vector<ImageDescriptor> drive{describe_contrast(pixels, kWidth, kHeight),
                                     describe_contrast(brighter, kWidth, kHeight),
                                     describe_contrast(cut_out(2, 5), kWidth, kHeight)};
  ASSERT_EQ(drive[0].values.size(), static_cast<size_t>(kWidth * kHeight));
  EXPECT_GT(similarity(drive[0], drive[1], 0), 0.99);
  EXPECT_LT(similarity(drive[0], drive[2], 0), 0.5);
  // A pixel in standard deviations of its window.
  const std::vector<uint8_t> step{10, 10, 10, 10, 30, 10, 10, 10, 10};
  constexpr double kMean = 110.0 / 9, kVariance = 1700.0 / 9 - kMean * kMean;
  EXPECT_NEAR(describe_contrast(step, 3, 3, 3).values[4], (30 - kMean) / std::sqrt(kVariance + 1),
              1e-4);
}

}  // namespace
}  // namespace infuse::places
