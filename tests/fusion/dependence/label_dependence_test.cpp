#include "fusion/dependence/label_dependence.hpp"

#include <gtest/gtest.h>

#include "tests/fusion/dependence/plain_fit.hpp"

namespace infuse::dependence {
namespace {

using Eigen::MatrixXd;

FitOptions fixed_fit(double sigma, double lambda) {
  FitOptions options;
  options.sigmas = {sigma};
  options.lambdas = {lambda};
  return options;
}

LabelDependence prepared(const MatrixXd& x, const FitOptions& options) {
  LabelDependence dependence(options);
  dependence.prepare(x);
  return dependence;
}

TEST(LabelDependence, EqualsTheDenseKroneckerSolve) {
  for (const double lambda : {1e-4, 0.02, 1.0}) {
    for (const double sigma : {0.3, 0.7, 3.0}) {
      const MatrixXd x = normal_samples(30, 2, 3);
      const std::vector<int32_t> labels = make_labels(x, 4, 4);
      // Five labels, the last of which does not occur.
      const PlainFit plain(FitMeasure::kSmi, plain_kernel(x, x, sigma), indicators(labels, 5),
                           MatrixXd::Zero(30, 30), MatrixXd::Identity(5, 5), lambda);
      const FitEstimate found = prepared(x, fixed_fit(sigma, lambda)).evaluate(labels, 5);
      EXPECT_STREQ(found.reason, "");
      EXPECT_EQ(found.hyper_parameters, (HyperParameters{sigma, lambda}));
      EXPECT_NEAR(found.value, plain.value(), 1e-9) << sigma << " " << lambda;
    }
  }
}

TEST(LabelDependence, WorksWithOneCentre) {
  FitOptions options = fixed_fit(0.7, 0.1);
  options.centres = 1;
  const MatrixXd x = normal_samples(40, 2, 5);
  const std::vector<int32_t> labels = make_labels(x, 3, 6);
  Random random(options.seed);
  const MatrixXd centre = x(choose_subset(40, 1, random), Eigen::all);
  const PlainFit plain(FitMeasure::kSmi, plain_kernel(x, centre, 0.7), indicators(labels, 3),
                       MatrixXd::Zero(1, 1), MatrixXd::Identity(3, 3), 0.1);
  EXPECT_NEAR(prepared(x, options).evaluate(labels, 3).value, plain.value(), 1e-12);
}

TEST(LabelDependence, CrossValidationChoosesLikeThePlainImplementation) {
  const FitOptions options = small_grid();
  std::vector<HyperParameters> all;
  LabelDependence dependence(options);
  for (uint64_t trial = 0; trial < 12; ++trial) {
    const MatrixXd x = normal_samples(53, 2, 10 + trial);
    const std::vector<int32_t> labels = make_labels(x, 3, 30 + trial);
    dependence.prepare(x);
    const FitEstimate found = dependence.evaluate(labels, 3);
    EXPECT_EQ(found.hyper_parameters,
              plain_choice(FitMeasure::kSmi, x, nullptr, labels, 3, options));
    EXPECT_EQ(dependence.evaluate(labels, 3, found.hyper_parameters).value, found.value);
    all.push_back(found.hyper_parameters);
  }
  EXPECT_TRUE(std::any_of(all.begin(), all.end(), [&](const auto& h) { return !(h == all[0]); }));
}

TEST(LabelDependence, ReusedObjectGivesTheValuesOfANewOne) {
  FitOptions options;
  options.centres = 25;
  LabelDependence shared(options);
  for (const int n : {200, 90, 17, 310, 200}) {
    const MatrixXd x = normal_samples(n, n == 90 ? 2 : 4, 40 + static_cast<uint64_t>(n));
    shared.prepare(x);
    LabelDependence fresh = prepared(x, options);
    for (int count = 2; count < 7; count += 2) {
      const auto labels = make_labels(x, count, 50);
      const FitEstimate one = shared.evaluate(labels, count), other = fresh.evaluate(labels, count);
      EXPECT_EQ(one.value, other.value);
      EXPECT_EQ(one.hyper_parameters, other.hyper_parameters);
      EXPECT_NE(one.value, 0);
    }
  }
}

TEST(LabelDependence, ReportsReasonForInvalidInput) {
  const MatrixXd x = normal_samples(30, 2, 500);
  const std::vector<int32_t> labels = make_labels(x, 3, 501), alike(30, 1);
  LabelDependence side{FitOptions{}};
  EXPECT_STREQ(side.evaluate(labels, 3).reason, "no samples");
  MatrixXd with_nan = x;
  with_nan(4, 1) = std::numeric_limits<double>::quiet_NaN();
  side.prepare(with_nan);
  EXPECT_STREQ(side.reason(), "a sample is not finite");
  EXPECT_STREQ(side.evaluate(labels, 3).reason, "a sample is not finite");
  side.prepare(x.topRows(4));
  EXPECT_STREQ(side.reason(), "fewer samples than folds");
  side.prepare(x);
  EXPECT_STREQ(side.reason(), "");
  EXPECT_STREQ(side.evaluate(alike, 3).reason, "all labels are equal");
  EXPECT_STREQ(side.evaluate(labels, 2).reason, "a label is not between 0 and label_count − 1");
  EXPECT_STREQ(side.evaluate(std::span(labels).first(9), 3).reason,
               "the two sides differ in length");
  EXPECT_STREQ(side.evaluate(labels, 3, HyperParameters{7, 1}).reason,
               "the given sigma is not in the grid");
  EXPECT_STREQ(side.evaluate(labels, 3, HyperParameters{1, 0}).reason,
               "the given lambda is not between 1e-12 and 1e12");
  EXPECT_TRUE(side.evaluate(labels, 3).usable());
  FitOptions invalid;
  invalid.lambdas = {0.0};
  EXPECT_STREQ(prepared(x, invalid).reason(), "invalid options");
}

TEST(LabelDependence, SingularKernelsAndExtremeScalesGiveFiniteValuesOrAReason) {
  MatrixXd twins = normal_samples(30, 2, 600);
  for (Eigen::Index i = 2; i < 30; ++i) twins.row(i) = twins.row(i % 2);
  std::vector<int32_t> each(30);
  for (int i = 0; i < 30; ++i) each[static_cast<size_t>(i)] = i;  // as many labels as samples
  for (const double scale : {1e-90, 1e-3, 1.0, 1e3, 1e90}) {
    for (const double lambda : {1e-12, 1e-3, 1e12}) {
      FitOptions options = fixed_fit(1.0, lambda);
      options.sigmas = {0.5, 1.0};
      const FitEstimate answer = prepared(scale * twins, options).evaluate(each, 30);
      EXPECT_TRUE(std::isfinite(answer.value));
    }
  }
}

}  // namespace
}  // namespace infuse::dependence
