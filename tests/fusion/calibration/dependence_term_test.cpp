#include "fusion/calibration/dependence_term.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "fusion/calibration/named_measures.hpp"
#include "fusion/dependence/joint_histogram.hpp"

namespace infuse::calibration {
namespace {

using enum LidarFeature;

double normal(std::mt19937_64& random) {
  const auto even = [&] { return (static_cast<double>(random() >> 11) + 0.5) * 0x1p-53; };
  return std::sqrt(-2 * std::log(even())) * std::cos(2 * M_PI * even());
}

/// Points whose two lidar features are independent normal variables.
VisiblePoints two_features(size_t n, uint64_t seed) {
  std::mt19937_64 random(seed);
  VisiblePoints points;
  for (size_t i = 0; i < n; ++i) {
    for (auto* axis : {&points.x, &points.y, &points.z}) axis->push_back(1);
    for (const LidarFeature feature : {kRelativeReflectivity, kNormalX}) {
      points.lidar[index(feature)].push_back(static_cast<float>(normal(random)));
    }
  }
  points.blocks.push_back({.scene = 0, .begin = 0, .end = n});
  return points;
}

TermOptions both_features(Estimator estimator) {
  return {.measure = Measure::kSquaredLossMutualInformation,
          .estimator = estimator,
          .lidar = {kRelativeReflectivity, kNormalX},
          .image = {ImageFeature::kLocalGrey, ImageFeature::kEdge},
          .equalize = false,
          .bags = 10};
}

TEST(LeastSquaresTerm, MatchesTheClosedFormOfNormalVariables) {
  // SMI of a normal pair of correlation r is ½ r²/(1 − r²); pairs that are independent of each
  // other multiply 2 SMI + 1.
  const VisiblePoints points = two_features(4000, 1);
  std::mt19937_64 random(2);
  const double r = 0.5;
  std::vector<float> image;
  for (const LidarFeature feature : {kRelativeReflectivity, kNormalX}) {
    for (const float x : points.lidar[index(feature)]) {
      image.push_back(static_cast<float>(r * x + std::sqrt(1 - r * r) * normal(random)));
    }
  }
  const double one = r * r / (1 - r * r);
  const double expected = 0.5 * ((1 + one) * (1 + one) - 1);
  for (const Estimator estimator : {Estimator::kLsmi, Estimator::kBlsmi}) {
    const auto estimate = make_term(both_features(estimator), points)->evaluate(image, {});
    ASSERT_TRUE(estimate.usable()) << estimate.reason;
    EXPECT_NEAR(estimate.value, expected, 0.12);
  }
}

TEST(LeastSquaresTerm, FindsDependenceOfTwoFeaturesJointly) {
  const VisiblePoints points = two_features(4000, 3);
  std::mt19937_64 random(4);
  std::vector<float> image(2 * points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    const float a = points.lidar[index(kRelativeReflectivity)][i];
    const float b = points.lidar[index(kNormalX)][i];
    image[i] = (a > 0) == (b > 0) ? 1.0F : 0.0F;
    image[points.size() + i] = static_cast<float>(normal(random));
  }
  TermOptions together = both_features(Estimator::kBlsmi);
  TermOptions alone = together;
  alone.lidar = {kRelativeReflectivity};
  EXPECT_GT(make_term(together, points)->evaluate(image, {}).value, 0.1);
  EXPECT_LT(std::abs(make_term(alone, points)->evaluate(image, {}).value), 0.02);
}

TEST(LeastSquaresTerm, PointsOutsideTheCameraModelAreIgnored) {
  const VisiblePoints points = two_features(3000, 5);
  std::vector<float> image(2 * points.size(), 0.5F);
  std::mt19937_64 random(6);
  for (float& value : image) value = static_cast<float>(normal(random));
  image[7] = dependence::kAbsent;
  std::vector<float> gradient(image.size());
  const auto term = make_term(both_features(Estimator::kBlsmi), points);
  EXPECT_TRUE(term->evaluate(image, gradient).usable());
  for (const float slope : gradient) EXPECT_TRUE(std::isfinite(slope));
}

TEST(SelectTermPoints, PointsWithoutAnEdgeAreLeftOutUnlessItIsOneOfSeveralFeatures) {
  VisiblePoints points = two_features(4, 7);
  points.lidar[index(kDiscontinuity)] = {1.0F, features::kNotCompared, 0.0F,
                                         features::kNotCompared};
  points.lidar[index(kNormalX)][0] = features::kNotCompared;
  EXPECT_EQ(select_term_points({.lidar = {kDiscontinuity}}, points), (std::vector<uint32_t>{0, 2}));
  EXPECT_EQ(select_term_points({.lidar = {kRelativeReflectivity, kDiscontinuity}}, points),
            (std::vector<uint32_t>{0, 1, 2, 3}));
  EXPECT_EQ(select_term_points({.lidar = {kDiscontinuity, kNormalX}}, points),
            (std::vector<uint32_t>{1, 2, 3}));
}

TEST(TermOptions, SayWhatIsWrong) {
  EXPECT_FALSE(TermOptions{}.invalid());
  EXPECT_TRUE((TermOptions{.lidar = {}}.invalid()));
  EXPECT_TRUE((TermOptions{.image = {}}.invalid()));
  EXPECT_TRUE((TermOptions{.weight = 0}.invalid()));
  EXPECT_TRUE((TermOptions{.bins = 3}.invalid()));
  EXPECT_TRUE((TermOptions{.bins = 2000}.invalid()));
  EXPECT_TRUE((TermOptions{.bags = 0}.invalid()));
  EXPECT_TRUE((TermOptions{.lidar = {kRelativeReflectivity, kNormalX}}.invalid()));
  EXPECT_FALSE(both_features(Estimator::kLsmi).invalid());
}

TEST(NamedMeasures, AreAllValidAndFoundByName) {
  for (const NamedMeasure& measure : named_measures()) {
    EXPECT_EQ(find_measure(measure.name), &measure);
    for (const TermOptions& term : measure.terms) EXPECT_FALSE(term.invalid()) << measure.name;
    for (const TermOptions& term : measure.search_terms)
      EXPECT_FALSE(term.invalid()) << measure.name;
  }
  EXPECT_EQ(find_measure("no such measure"), nullptr);
  EXPECT_STREQ(named_measures().front().name, "joint");
}

}  // namespace
}  // namespace infuse::calibration
