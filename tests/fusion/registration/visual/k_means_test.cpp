#include "fusion/registration/visual/k_means.hpp"

#include <gtest/gtest.h>

#include <random>

namespace infuse::registration {
namespace {

TEST(KMeans, FindsSeparateClusters) {
  std::mt19937 random(1);
  std::normal_distribution<float> noise(0, 0.1F);
  Eigen::MatrixXf features(2, 600);
  for (int i = 0; i < 600; ++i) {
    const float corner = i % 6 < 3 ? 0.0F : i % 6 < 5 ? 10.0F : 20.0F;  // 300, 200 and 100 of them
    features.col(i) << corner + noise(random), -corner + noise(random);
  }
  const Codebook codebook = learn_codebook(features, 3, 1);
  EXPECT_FALSE(codebook.invalid());
  for (const auto& [corner, share] : {std::pair{0.0F, 0.5}, {10.0F, 1 / 3.0}, {20.0F, 1 / 6.0}}) {
    Eigen::Index word = 0;
    const float distance = (codebook.words.colwise() - Eigen::Vector2f(corner, -corner))
                               .colwise()
                               .norm()
                               .minCoeff(&word);
    EXPECT_LT(distance, 0.05F);
    EXPECT_NEAR(codebook.frequencies[static_cast<size_t>(word)], share, 0.01);
  }
}

}  // namespace
}  // namespace infuse::registration
