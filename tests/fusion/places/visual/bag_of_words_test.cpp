#include "fusion/places/visual/bag_of_words.hpp"

#include <gtest/gtest.h>

#include <random>

namespace infuse::places {
namespace {

TEST(BagOfWords, IgnoresWhatAllPlacesHave) {
  const BagOfWords bag({{0, 0, 0, 1}, {0, 0, 0, 2}, {0, 3, 3, 3}}, 5);
  const Eigen::VectorXd same = bag.similarities({0, 1});
  EXPECT_NEAR(same[0], 1, 1e-12);
  EXPECT_NEAR(same[1], 0, 1e-12);
  EXPECT_EQ(bag.similarities({4}).norm(), 0);
  EXPECT_EQ(bag.similarities({}).norm(), 0);
}

TEST(SiftKeypoints, SayInWhichPartOfTheImageTheyAre) {
  CameraFrame frame;
  frame.width = 96;
  frame.height = 64;
  frame.format = PixelFormat::kGrey8;
  frame.pixels.assign(static_cast<size_t>(96 * 64), 90);
  EXPECT_EQ(sift_keypoints(frame).size(), 0);
  std::mt19937 random(2);
  for (int blob = 0; blob < 30; ++blob) {  // in the right half, which is columns 4 to 7 of 8
    const auto row = 4 + random() % 56, column = 54 + random() % 38;
    for (size_t i = row - 2; i <= row + 2; ++i) {
      for (size_t j = column - 2; j <= column + 2; ++j) frame.pixels[i * 96 + j] = 220;
    }
  }
  const ImageKeypoints found = sift_keypoints(frame);
  EXPECT_GT(found.size(), 5);
  ASSERT_EQ(found.descriptors.cols(), static_cast<Eigen::Index>(found.size()));
  for (Eigen::Index k = 0; k < found.descriptors.cols(); ++k)
    EXPECT_NEAR(found.descriptors.col(k).norm(), 1, 1e-5F);
  for (const uint32_t part : found.parts) {
    EXPECT_LT(part, 48);
    EXPECT_GE(part % 8, 4);
  }
}

TEST(PlacedWords, DifferWhereThePartOfTheImageDoes) {
  const registration::Codebook codebook{Eigen::MatrixXf::Identity(128, 3), {0.3, 0.3, 0.4}};
  const ImageKeypoints keypoints{codebook.words, {0, 47, 5}};
  EXPECT_EQ(placed_words(codebook, keypoints), (std::vector<uint32_t>{0, 47 * 3 + 1, 5 * 3 + 2}));
  EXPECT_EQ(number_of_words(codebook), 48 * 3);
}

}  // namespace
}  // namespace infuse::places
