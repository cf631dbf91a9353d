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

TEST(SiftDescriptors, AreThoseOfTheStrongestKeypoints) {
  CameraFrame frame;
  frame.width = 96;
  frame.height = 64;
  frame.format = PixelFormat::kGrey8;
  frame.pixels.assign(static_cast<size_t>(96 * 64), 90);
  EXPECT_EQ(sift_descriptors(frame, 50).cols(), 0);
  std::mt19937 random(2);
  for (int blob = 0; blob < 30; ++blob) {
    const auto row = 4 + random() % 56, column = 4 + random() % 88;
    for (size_t i = row - 2; i <= row + 2; ++i) {
      for (size_t j = column - 2; j <= column + 2; ++j) frame.pixels[i * 96 + j] = 220;
    }
  }
  const Eigen::MatrixXf found = sift_descriptors(frame, 10);
  EXPECT_GT(found.cols(), 5);
  EXPECT_LE(found.cols(), 12);  // a keypoint of two orientations counts twice
  for (Eigen::Index k = 0; k < found.cols(); ++k) EXPECT_NEAR(found.col(k).norm(), 1, 1e-5F);
}

}  // namespace
}  // namespace infuse::places
