#include "fusion/registration/visual/codebook.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace infuse::registration {
namespace {

TEST(Codebook, QuantisesToTheNearestWord) {
  std::srand(3);
  Codebook codebook{Eigen::MatrixXf::Random(7, 20), std::vector<double>(20, 0.05)};
  const Eigen::MatrixXf features = Eigen::MatrixXf::Random(7, 200);
  const std::vector<uint32_t> words = quantise(codebook, features);
  ASSERT_EQ(words.size(), 200U);
  for (Eigen::Index i = 0; i < 200; ++i) {
    Eigen::Index nearest = 0;
    (codebook.words.colwise() - features.col(i)).colwise().squaredNorm().minCoeff(&nearest);
    EXPECT_EQ(words[static_cast<size_t>(i)], nearest);
  }
}

TEST(Codebook, NamesWhatIsWrong) {
  EXPECT_TRUE(Codebook().invalid());
  Codebook codebook{Eigen::MatrixXf::Zero(2, 2), {0.5, 0.5}};
  EXPECT_FALSE(codebook.invalid());
  codebook.frequencies = {1, 0};
  EXPECT_TRUE(codebook.invalid());
  codebook.frequencies = {0.5, 0.4};
  EXPECT_TRUE(codebook.invalid());
  codebook.frequencies = {1};
  EXPECT_TRUE(codebook.invalid());
  codebook.frequencies = {0.5, 0.5};
  codebook.words(0, 1) = NAN;
  EXPECT_TRUE(codebook.invalid());
}

}  // namespace
}  // namespace infuse::registration
