#include "fusion/registration/visual/codeword_information.hpp"

#include <gtest/gtest.h>

#include "fusion/geometry/rigid_motion.hpp"
#include "tests/fusion/registration/visual/invented_codewords.hpp"

namespace infuse::registration {
namespace {

constexpr size_t kEightWords = 8;

/// Partner of a point by comparing all: most similar word, then nearest; −1: none within the
/// radius.
int64_t find_partner(const CodewordCloud& target, const Eigen::Vector3f& p, uint32_t word,
                     float radius) {
  int64_t best = -1;
  std::pair<float, float> least;
  for (size_t j = 0; j < target.size(); ++j) {
    const float distance = (target.points.col(static_cast<Eigen::Index>(j)) - p).squaredNorm();
    if (distance > radius * radius) continue;
    const float unlike = float(target.words[j]) - float(word);
    const std::pair<float, float> key{unlike * unlike, distance};
    if (best < 0 || key < least) best = static_cast<int64_t>(j), least = key;
  }
  return best;
}

TEST(CodewordInformation, FindsTheCorrespondencesOfBruteForce) {
  std::mt19937 random(2);
  const Codebook codebook = line_of_words(kEightWords);
  const CodewordCloud target = draw_codewords(800, kEightWords, random);
  CodewordCloud source = draw_codewords(300, kEightWords, random);
  source.points.col(5).setConstant(NAN);
  source.points.col(6).setConstant(1e30F);
  CodewordInformation information(codebook, target, ShrinkageRule::kNone, 500);
  const Eigen::Isometry3d T =
      geometry::exp((geometry::Vector6() << 0.02, -0.01, 0.3, 2, -1, 0.2).finished());
  for (const double radius : {0.4, 1.5, 3.0}) {
    information.set_radius(radius);
    const double value = information.evaluate(source, T);
    dependence::ShrunkInformation expected(codebook.frequencies);
    size_t pairs = 0;
    for (size_t i = 0; i < source.size(); ++i) {
      const Eigen::Vector3f p =
          T.linear().cast<float>() * source.points.col(static_cast<Eigen::Index>(i)) +
          T.translation().cast<float>();
      if (!p.allFinite()) continue;
      const int64_t partner = find_partner(target, p, source.words[i], static_cast<float>(radius));
      if (partner < 0) continue;
      ASSERT_LT(pairs, information.correspondences().size());
      EXPECT_EQ(information.correspondences()[pairs].source, i);
      EXPECT_EQ(information.correspondences()[pairs++].target, partner);
      expected.add(source.words[i], target.words[static_cast<size_t>(partner)]);
    }
    EXPECT_EQ(pairs, information.correspondences().size());
    EXPECT_NEAR(value, expected.value(0), 1e-12);
  }
}

TEST(CodewordInformation, IsHighestAtTheTrueMotion) {
  std::mt19937 random(4);
  const CodewordCloud target = draw_codewords(500, kEightWords, random);
  const Eigen::Isometry3d truth(Eigen::Translation3d(4, 0.5, 0));
  const CodewordCloud source = see_again(target, truth, kEightWords, 0.1F, 0.4, random);
  for (const auto rule : {ShrinkageRule::kByCorrespondences, ShrinkageRule::kOptimal}) {
    CodewordInformation information(line_of_words(kEightWords), target, rule, 500);
    information.set_radius(0.5);
    const double at_truth = information.evaluate(source, truth);
    for (const double offset : {-4.0, -2.0, 2.0, 4.0}) {
      const Eigen::Isometry3d moved = truth * Eigen::Translation3d(offset, 0, 0);
      EXPECT_LT(information.evaluate(source, moved), 0.5 * at_truth) << offset;
    }
  }
}

}  // namespace
}  // namespace infuse::registration
