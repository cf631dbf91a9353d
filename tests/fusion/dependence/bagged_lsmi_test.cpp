#include "fusion/dependence/bagged_lsmi.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "fusion/dependence/prepared_dependence.hpp"
#include "tests/fusion/dependence/random_samples.hpp"

namespace infuse::dependence {
namespace {

using Eigen::MatrixXd;

BagOptions small_bags(int bags, int bag_size, int centres) {
  BagOptions options;
  options.bags = bags;
  options.bag_size = bag_size;
  options.fit.centres = centres;
  return options;
}

TEST(BaggedLsmi, OneBagOfAllSamplesEqualsLsmi) {
  const MatrixXd x = normal_samples(60, 2, 1), y = correlated_with(x, 0.6, 2);
  for (const SmiForm form : {SmiForm::kLinear, SmiForm::kPlugIn}) {
    BagOptions options = small_bags(3, 60, 60);
    options.fit.form = form;
    PreparedDependence plain(FitMeasure::kSmi, x, options.fit);
    BaggedLsmi bagged(x, options);
    MatrixXd bagged_gradient, plain_gradient;
    const FitEstimate found = bagged.evaluate(y, &bagged_gradient);
    EXPECT_STREQ(found.reason, "");
    const FitEstimate truth = plain.evaluate(y, found.hyper_parameters, &plain_gradient);
    EXPECT_NEAR(found.value, truth.value, 1e-11);
    EXPECT_TRUE(bagged_gradient.isApprox(plain_gradient, 1e-8));
    EXPECT_EQ(*bagged.hyper_parameters(), found.hyper_parameters);
  }
}

TEST(BaggedLsmi, GradientEqualsCentralDifferences) {
  const MatrixXd x = normal_samples(80, 3, 3), y = correlated_with(x, 0.7, 4).leftCols(2);
  BaggedLsmi bagged(x, small_bags(4, 30, 10));
  bagged.set_hyper_parameters({0.9, 0.02});
  MatrixXd gradient;
  EXPECT_EQ(bagged.evaluate(y, &gradient).value, bagged.evaluate(y).value);
  EXPECT_GT(gradient.norm(), 0.01);
  const auto value = [&](const MatrixXd& at) { return bagged.evaluate(at).value; };
  EXPECT_LT((gradient - central_differences(value, y, 1e-5)).cwiseAbs().maxCoeff(), 1e-8);
}

TEST(BaggedLsmi, SeedFixesTheBagsAndMoreBagsVaryLess) {
  const MatrixXd x = normal_samples(1000, 1, 5), y = correlated_with(x, 0.5, 6);
  const auto value = [&](int bags, uint64_t seed) {
    BagOptions options = small_bags(bags, 100, 20);
    options.fit.seed = seed;
    BaggedLsmi bagged(x, options);
    bagged.set_hyper_parameters({1.0, 0.01});
    return bagged.evaluate(y).value;
  };
  EXPECT_EQ(value(5, 7), value(5, 7));
  RunningMean one, many;
  for (uint64_t seed = 0; seed < 30; ++seed) {
    one.add(value(1, seed));
    many.add(value(16, 100 + seed));
  }
  // Sixteen bags: about a quarter of the standard deviation.
  EXPECT_LT(many.standard_error(), 0.45 * one.standard_error());
  EXPECT_NEAR(many.mean(), one.mean(), 4 * one.standard_error());
}

TEST(BaggedLsmi, KeepsTheHyperParametersOfTheFirstEvaluation) {
  const MatrixXd x = normal_samples(300, 1, 8), y = correlated_with(x, 0.9, 9);
  BaggedLsmi bagged(x, small_bags(3, 100, 20));
  EXPECT_FALSE(bagged.hyper_parameters());
  const HyperParameters first = bagged.evaluate(y).hyper_parameters;
  EXPECT_EQ(bagged.evaluate(normal_samples(300, 1, 10)).hyper_parameters, first);
  bagged.set_hyper_parameters({0.123, 0.5});
  EXPECT_EQ(bagged.evaluate(y).hyper_parameters, (HyperParameters{0.123, 0.5}));
}

TEST(BaggedLsmi, ReportsReasonForInvalidInput) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const MatrixXd x = normal_samples(50, 2, 11);
  const BagOptions options = small_bags(2, 20, 5);
  const auto reason = [&](const MatrixXd& fixed, const BagOptions& with) {
    return BaggedLsmi(fixed, with).evaluate(x).reason;
  };
  EXPECT_STREQ(reason(MatrixXd(0, 0), options), "fewer than two samples");
  EXPECT_STREQ(reason(MatrixXd::Ones(50, 1), options), "all samples are equal");
  EXPECT_STREQ(reason(MatrixXd::Constant(50, 1, kNan), options), "a sample is not finite");
  EXPECT_STREQ(reason(x, small_bags(2, 51, 5)), "fewer samples than bag_size");
  EXPECT_STREQ(reason(x, small_bags(0, 20, 5)), "invalid options");
  EXPECT_STREQ(reason(x, small_bags(2, 4, 5)), "fewer samples than folds");

  BaggedLsmi bagged(x, options);
  MatrixXd gradient = x, bad = x;
  bad(49, 1) = kNan;
  EXPECT_STREQ(bagged.evaluate(bad, &gradient).reason, "a sample is not finite");
  EXPECT_EQ(gradient.size(), 0);
  EXPECT_STREQ(bagged.evaluate(x.topRows(30)).reason, "the two sides differ in length");
  bagged.set_hyper_parameters({kNan, 1});
  EXPECT_STREQ(bagged.evaluate(x).reason, "the given hyper-parameters are out of range");
  bagged.set_hyper_parameters({1, 0.01});
  EXPECT_TRUE(bagged.evaluate(x).usable());

  // The first bag may be constant even if the samples are not.
  MatrixXd spike = MatrixXd::Zero(50, 1);
  spike(0) = 1;
  BaggedLsmi hollow(x, small_bags(20, 4, 4));
  hollow.set_hyper_parameters({1, 0.01});
  EXPECT_TRUE(std::isfinite(hollow.evaluate(spike).value));
}

TEST(BagOptions, ReportInvalidValues) {
  EXPECT_FALSE(BagOptions().invalid());
  EXPECT_TRUE(small_bags(0, 20, 5).invalid());
  EXPECT_TRUE(small_bags(5, 1, 5).invalid());
  EXPECT_TRUE(small_bags(5, 20, 0).invalid());
}

}  // namespace
}  // namespace infuse::dependence
