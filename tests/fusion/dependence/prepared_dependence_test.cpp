#include "fusion/dependence/prepared_dependence.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>

#include "tests/fusion/dependence/plain_fit.hpp"
#include "tests/fusion/dependence/random_samples.hpp"

namespace infuse::dependence {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr FitMeasure kMeasures[] = {FitMeasure::kSmi, FitMeasure::kQmi, FitMeasure::kSce};

FitOptions fixed(double sigma, double lambda, int centres = 10000) {
  FitOptions options;
  options.sigmas = {sigma};
  options.lambdas = {lambda};
  options.centres = centres;
  return options;
}

TEST(PreparedDependence, ReferenceValuesOfLsmi) {
  MatrixXd x(8, 1), y(8, 1);
  x << -1.5, -1, -0.5, -0.1, 0.2, 0.6, 1.1, 1.7;
  y << -1.2, -1.1, -0.2, 0.1, 0, 0.9, 0.8, 1.9;
  const double table[][4] = {{0.5, 0.1, 0.514085519945, 0.801921869572},
                             {1.0, 0.1, 0.376900112026, 0.508008987661},
                             {1.0, 0.01, 0.662947545006, 0.787257756873}};
  for (const auto& [sigma, lambda, linear, plug_in] : table) {
    FitOptions options = fixed(sigma, lambda);
    EXPECT_NEAR(PreparedDependence(FitMeasure::kSmi, x, options).evaluate(y).value, linear, 1e-12);
    options.form = SmiForm::kPlugIn;
    const FitEstimate found = PreparedDependence(FitMeasure::kSmi, x, options).evaluate(y);
    EXPECT_NEAR(found.value, plug_in, 1e-12);
    EXPECT_EQ(found.hyper_parameters, (HyperParameters{sigma, lambda}));
  }
}

TEST(PreparedDependence, SamplesEqualTheDenseKroneckerSolve) {
  const MatrixXd x = normal_samples(14, 2, 1),
                 y = normal_samples(14, 3, 2) + x.col(0) * MatrixXd::Ones(1, 3);
  for (const FitMeasure measure : kMeasures) {
    for (const double lambda : {1e-3, 0.1}) {
      PlainFit plain(measure, plain_kernel(x, x, 0.9), plain_kernel(y, y, 0.9),
                     plain_integral(x, 0.9), plain_integral(y, 0.9), lambda);
      for (const SmiForm form : {SmiForm::kLinear, SmiForm::kPlugIn}) {
        FitOptions options = fixed(0.9, lambda);
        options.form = plain.form = form;
        const FitEstimate found = PreparedDependence(measure, x, options).evaluate(y);
        EXPECT_STREQ(found.reason, "");
        EXPECT_NEAR(found.value, plain.value(), 1e-10);
      }
    }
  }
}

TEST(PreparedDependence, LabelsEqualTheDenseKroneckerSolve) {
  const MatrixXd x = normal_samples(30, 2, 3);
  std::vector<int32_t> labels = make_labels(x, 4, 4);
  for (const FitMeasure measure : kMeasures) {
    // Five labels, the last of which does not occur.
    const PlainFit plain(measure, plain_kernel(x, x, 0.7), indicators(labels, 5),
                         plain_integral(x, 0.7), MatrixXd::Identity(5, 5), 0.02);
    const FitEstimate found = PreparedDependence(measure, x, fixed(0.7, 0.02)).evaluate(labels, 5);
    EXPECT_STREQ(found.reason, "");
    EXPECT_NEAR(found.value, plain.value(), 1e-10);
  }
}

TEST(PreparedDependence, CrossValidationChoosesLikeThePlainImplementation) {
  FitOptions options = small_grid();
  std::vector<HyperParameters> all;
  for (const FitMeasure measure : kMeasures) {
    for (uint64_t trial = 0; trial < 4; ++trial) {
      options.seed = 1 + trial;
      const MatrixXd x = normal_samples(53, 2, 10 + trial);
      const MatrixXd y = correlated_with(x, 0.3 + 0.2 * static_cast<double>(trial), 20 + trial);
      const std::vector<int32_t> labels = make_labels(x, 3, 30 + trial);
      PreparedDependence prepared(measure, x, options);
      const FitEstimate of_samples = prepared.evaluate(y), of_labels = prepared.evaluate(labels, 3);
      EXPECT_EQ(of_samples.hyper_parameters, plain_choice(measure, x, &y, {}, 0, options));
      EXPECT_EQ(of_labels.hyper_parameters, plain_choice(measure, x, nullptr, labels, 3, options));
      // The same value with the hyper-parameters chosen before.
      EXPECT_EQ(prepared.evaluate(y, of_samples.hyper_parameters).value, of_samples.value);
      EXPECT_EQ(prepared.evaluate(labels, 3, of_labels.hyper_parameters).value, of_labels.value);
      all.push_back(of_samples.hyper_parameters);
    }
  }
  EXPECT_TRUE(std::any_of(all.begin(), all.end(), [&](const auto& h) { return h != all[0]; }));
}

TEST(PreparedDependence, ReusedObjectGivesTheValuesOfNewOnes) {
  const MatrixXd x = normal_samples(200, 4, 40);
  FitOptions options;
  options.centres = 25;
  PreparedDependence shared(FitMeasure::kSmi, x, options);
  for (uint64_t h = 0; h < 5; ++h) {
    const auto labels = make_labels(x, 2 + static_cast<int>(h), 50 + h);
    const int count = 2 + static_cast<int>(h);
    const FitEstimate together = shared.evaluate(labels, count);
    const FitEstimate alone =
        PreparedDependence(FitMeasure::kSmi, x, options).evaluate(labels, count);
    EXPECT_EQ(together.value, alone.value);
    EXPECT_EQ(together.hyper_parameters, alone.hyper_parameters);
    const MatrixXd y = correlated_with(x, 0.5, 60 + h);
    EXPECT_EQ(shared.evaluate(y).value,
              PreparedDependence(FitMeasure::kSmi, x, options).evaluate(y).value);
  }
}

TEST(PreparedDependence, RelabellingChangesNothing) {
  const MatrixXd x = normal_samples(150, 3, 70);
  std::vector<int32_t> labels = make_labels(x, 4, 71), renamed;
  for (const int32_t label : labels) renamed.push_back((label * 3 + 2) % 5);
  FitOptions options;
  options.centres = 30;
  for (const FitMeasure measure : kMeasures) {
    PreparedDependence prepared(measure, x, options);
    const FitEstimate one = prepared.evaluate(labels, 4), other = prepared.evaluate(renamed, 5);
    EXPECT_NEAR(one.value, other.value, 1e-12);
    EXPECT_EQ(one.hyper_parameters, other.hyper_parameters);
  }
}

TEST(PreparedDependence, SmiAndQmiAreSymmetric) {
  const MatrixXd x = normal_samples(100, 2, 80), y = correlated_with(x, 0.7, 81);
  FitOptions options;
  options.centres = 20;
  for (const FitMeasure measure : {FitMeasure::kSmi, FitMeasure::kQmi}) {
    EXPECT_NEAR(PreparedDependence(measure, x, options).evaluate(y).value,
                PreparedDependence(measure, y, options).evaluate(x).value, 1e-11);
  }
}

TEST(PreparedDependence, GradientEqualsCentralDifferences) {
  const MatrixXd x = normal_samples(40, 3, 90);
  MatrixXd y = correlated_with(x, 0.6, 91).leftCols(2);
  for (const SmiForm form : {SmiForm::kLinear, SmiForm::kPlugIn}) {
    FitOptions options = fixed(0.8, 0.01, 12);
    options.form = form;
    PreparedDependence prepared(FitMeasure::kSmi, x, options);
    MatrixXd gradient;
    const FitEstimate found = prepared.evaluate(y, {}, &gradient);
    EXPECT_EQ(found.value, prepared.evaluate(y).value);
    ASSERT_EQ(gradient.rows(), 40);
    ASSERT_EQ(gradient.cols(), 2);
    EXPECT_GT(gradient.norm(), 0.01);
    const auto value = [&](const MatrixXd& at) { return prepared.evaluate(at).value; };
    EXPECT_LT((gradient - central_differences(value, y, 1e-5)).cwiseAbs().maxCoeff(), 1e-8);
  }
}

// reference: n = 1000, b = 100, cross-validated.
TEST(PreparedDependence, BiasOfLsmiOnTheGaussian) {
  const double table[][3] = {
      {0.0, 0.000, 0.004}, {0.5, 0.168, 0.010}, {0.8, 0.61, 0.02}, {0.9, 1.07, 0.08}};
  for (const auto& [rho, value, within] : table) {
    RunningMean found;
    for (uint64_t trial = 0; trial < 12; ++trial) {
      const MatrixXd x = normal_samples(1000, 1, 100 + trial);
      FitOptions options;
      options.seed = trial;
      options.sigmas = {0.5, 1.0, 1.5};
      options.lambdas = {1e-4, 1e-2, 1.0};
      found.add(PreparedDependence(FitMeasure::kSmi, x, options)
                    .evaluate(correlated_with(x, rho, 200 + trial))
                    .value);
    }
    EXPECT_NEAR(found.mean(), value, within + 2 * found.standard_error()) << rho;
  }
}

TEST(PreparedDependence, QmiAndSceOfTheGaussian) {
  using std::numbers::pi;
  for (const double rho : {0.5, 0.8}) {
    RunningMean qmi, sce;
    for (uint64_t trial = 0; trial < 10; ++trial) {
      const MatrixXd x = normal_samples(1000, 1, 300 + trial);
      const MatrixXd y = correlated_with(x, rho, 400 + trial);
      FitOptions options;
      options.centres = 60;
      options.sigmas = {0.5, 0.75, 1.0};
      options.lambdas = {1e-3, 1e-2, 1e-1};
      qmi.add(PreparedDependence(FitMeasure::kQmi, x, options).evaluate(y).value);
      sce.add(PreparedDependence(FitMeasure::kSce, x, options).evaluate(y).value);
    }
    const double s = std::sqrt(1 - rho * rho);
    const double true_qmi = 1 / (4 * pi * s) + 1 / (4 * pi) - 1 / (pi * std::sqrt(4 - rho * rho));
    // −½∫∫p(x, y)²/p(x): the squared density of N(·, s²) integrates to 1/(2s√π).
    const double true_sce = -1 / (4 * s * std::sqrt(pi));
    EXPECT_NEAR(qmi.mean(), true_qmi, 0.1 * true_qmi + 4 * qmi.standard_error()) << rho;
    EXPECT_NEAR(sce.mean(), true_sce, -0.05 * true_sce + 4 * sce.standard_error()) << rho;
  }
}

TEST(PreparedDependence, ReportsReasonForInvalidInput) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const MatrixXd x = normal_samples(30, 2, 500);
  const FitOptions options;
  const std::vector<int32_t> labels = make_labels(x, 3, 501), alike(30, 1);
  const auto reason = [&](const MatrixXd& prepared, const FitOptions& with) {
    PreparedDependence side(FitMeasure::kSmi, prepared, with);
    const FitEstimate answer = side.evaluate(labels, 3), other = side.evaluate(x);
    EXPECT_STREQ(side.reason(), answer.reason);
    EXPECT_STREQ(side.reason(), other.reason);
    EXPECT_EQ(answer.value, 0.0);
    return answer.reason;
  };
  MatrixXd with_nan = x;
  with_nan(4, 1) = kNan;
  EXPECT_STREQ(reason(with_nan, options), "a sample is not finite");
  EXPECT_STREQ(reason(MatrixXd(0, 2), options), "fewer than two samples");
  EXPECT_STREQ(reason(MatrixXd::Ones(30, 2), options), "all samples are equal");
  EXPECT_STREQ(reason(x.topRows(4), options), "fewer samples than folds");
  FitOptions invalid;
  invalid.lambdas = {0.0};
  EXPECT_STREQ(reason(x, invalid), "invalid options");

  PreparedDependence side(FitMeasure::kSmi, x, options);
  MatrixXd gradient = MatrixXd::Ones(1, 1);
  EXPECT_STREQ(side.evaluate(with_nan, {}, &gradient).reason, "a sample is not finite");
  EXPECT_EQ(gradient.size(), 0);
  EXPECT_STREQ(side.evaluate(x.topRows(9)).reason, "the two sides differ in length");
  EXPECT_STREQ(side.evaluate(MatrixXd::Ones(30, 1)).reason, "all samples are equal");
  EXPECT_STREQ(side.evaluate(alike, 3).reason, "all labels are equal");
  EXPECT_STREQ(side.evaluate(labels, 2).reason, "a label is not between 0 and label_count − 1");
  EXPECT_STREQ(side.evaluate(labels, 3, HyperParameters{7, 1}).reason,
               "the given sigma is not in the grid");
  EXPECT_STREQ(side.evaluate(labels, 3, HyperParameters{1, kNan}).reason,
               "the given lambda is not between 1e-12 and 1e12");
  EXPECT_TRUE(side.evaluate(labels, 3).usable());
}

TEST(PreparedDependence, SingularKernelsAndExtremeScalesGiveFiniteValuesOrAReason) {
  MatrixXd twins = normal_samples(30, 2, 600);
  for (Index i = 2; i < 30; ++i) twins.row(i) = twins.row(i % 2);
  const MatrixXd y = normal_samples(30, 1, 601);
  std::vector<int32_t> each(30);
  for (int i = 0; i < 30; ++i) each[static_cast<size_t>(i)] = i;  // as many labels as samples
  for (const FitMeasure measure : kMeasures) {
    for (const double scale : {1e-90, 1e-3, 1.0, 1e3, 1e90}) {
      for (const double lambda : {1e-12, 1e-3, 1e12}) {
        PreparedDependence side(measure, scale * twins, fixed(1.0, lambda));
        MatrixXd gradient;
        for (const FitEstimate& answer : {side.evaluate(each, 30), side.evaluate(y),
                                          side.evaluate(scale * twins, {}, &gradient)}) {
          EXPECT_TRUE(std::isfinite(answer.value));
        }
        EXPECT_TRUE(gradient.allFinite());
      }
    }
  }
}

TEST(FitOptions, ReportInvalidValues) {
  EXPECT_FALSE(FitOptions().invalid());
  FitOptions options;
  options.sigmas = {};
  EXPECT_TRUE(options.invalid());
  options = {};
  options.sigmas = {-1};
  EXPECT_TRUE(options.invalid());
  options = {};
  options.lambdas = {std::numeric_limits<double>::quiet_NaN()};
  EXPECT_TRUE(options.invalid());
  options = {};
  options.folds = 1;
  EXPECT_TRUE(options.invalid());
  options = {};
  options.centres = 0;
  EXPECT_TRUE(options.invalid());
}

}  // namespace
}  // namespace infuse::dependence
