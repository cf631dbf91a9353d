#include "tests/study/dependence/estimators.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

namespace infuse::study {
namespace {

TEST(Estimators, KeysAreUnique) {
  std::set<std::string> keys;
  for (const Estimator& estimator : make_estimators()) {
    EXPECT_TRUE(keys.insert(estimator.key).second) << estimator.key;
  }
}

TEST(Estimators, EveryEstimatorIsUsableOnTheGaussian) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> draw;
  SamplePairs samples(2, 200);
  for (Eigen::Index i = 0; i < samples.cols(); ++i) {
    const double x = draw(random), noise = draw(random);
    samples.col(i) << x, kRho * x + std::sqrt(1 - kRho * kRho) * noise;
  }
  for (const Estimator& estimator : make_estimators()) {
    const Estimate estimate = estimator.estimate(samples);
    EXPECT_TRUE(estimate.usable()) << estimator.key << ": " << estimate.reason;
    // About five standard deviations of the least accurate estimators of accuracy.md.
    EXPECT_NEAR(estimate.value, estimator.truth, 1) << estimator.key;
  }
}

}  // namespace
}  // namespace infuse::study
