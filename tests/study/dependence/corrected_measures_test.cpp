#include "tests/study/dependence/corrected_measures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/fusion/dependence/joint_table.hpp"

namespace infuse::study {
namespace {

using dependence::joint_table;
using dependence::JointHistogram;
using dependence::kFewerSamplesThanBins;
using dependence::Measure;

constexpr double kReferenceTolerance = 5e-13;
constexpr Measure kAllMeasures[] = {Measure::kMutualInformation,
                                    Measure::kNormalisedMutualInformation, Measure::kChiSquared,
                                    Measure::kSquaredLossMutualInformation};
constexpr CountEntropyOptions::Estimator kEstimators[] = {
    CountEntropyOptions::Estimator::kMaximumLikelihood,
    CountEntropyOptions::Estimator::kMillerMadow,
    CountEntropyOptions::Estimator::kJamesStein,
    CountEntropyOptions::Estimator::kDirichlet,
    CountEntropyOptions::Estimator::kNemenman,
    CountEntropyOptions::Estimator::kChaoShen};

CountEntropyOptions with_estimator(CountEntropyOptions::Estimator estimator) {
  CountEntropyOptions options;
  options.estimator = estimator;
  return options;
}

JointHistogram reference_table() {
  return joint_table(std::vector<double>{1, 2, 3, 6, 5, 4}, 2, 3);
}

// Reference values: R package `entropy` 1.3.2.
TEST(CorrectedMeasures, ReferenceTable) {
  const JointHistogram table = reference_table();
  const Measure information = Measure::kMutualInformation;
  EXPECT_NEAR(
      measure(information, table, with_estimator(CountEntropyOptions::Estimator::kDirichlet)).value,
      0.024760325552, kReferenceTolerance);
  EXPECT_NEAR(
      measure(information, table, with_estimator(CountEntropyOptions::Estimator::kJamesStein))
          .value,
      0, kReferenceTolerance);
  EXPECT_EQ(james_stein_frequencies(table.mass).lambda, 1);
  EXPECT_NEAR(
      measure(information, table, with_estimator(CountEntropyOptions::Estimator::kChaoShen)).value,
      -0.071355585069, kReferenceTolerance);
}

TEST(CorrectedMeasures, MillerMadowSubtractsTheDegreesOfFreedom) {
  const double expected = 0.034504918061 - (2 - 1) * (3 - 1) / (2 * 21.0);
  EXPECT_NEAR(measure(Measure::kMutualInformation, reference_table(),
                      with_estimator(CountEntropyOptions::Estimator::kMillerMadow))
                  .value,
              expected, kReferenceTolerance);
}

TEST(CorrectedMeasures, IsSymmetricInItsSides) {
  const JointHistogram transposed = joint_table(std::vector<double>{1, 6, 2, 5, 3, 4}, 3, 2);
  for (const auto estimator : kEstimators) {
    const CountEntropyOptions options = with_estimator(estimator);
    EXPECT_NEAR(measure(Measure::kMutualInformation, reference_table(), options).value,
                measure(Measure::kMutualInformation, transposed, options).value, 1e-12);
  }
}

TEST(CorrectedMeasures, BadTablesGiveAReasonAndAFiniteValue) {
  const std::vector<JointHistogram> tables = {JointHistogram{},
                                              joint_table(std::vector<double>{0, 0, 0, 0}, 2, 2),
                                              joint_table(std::vector<double>{5, 0, 0, 0}, 2, 2),
                                              joint_table(std::vector<double>{5, 5, 0, 0}, 2, 2),
                                              joint_table(std::vector<double>{5, 0, 5, 0}, 2, 2),
                                              joint_table(std::vector<double>{5}, 1, 1)};
  for (const JointHistogram& table : tables) {
    for (const Measure which : kAllMeasures) {
      for (const auto estimator : kEstimators) {
        const Estimate estimate = measure(which, table, with_estimator(estimator));
        EXPECT_FALSE(estimate.usable());
        EXPECT_TRUE(std::isfinite(estimate.value));
      }
    }
  }
}

TEST(CorrectedMeasures, FewerSamplesThanBinsIsLiftedForEstimatorsMadeForFewSamples) {
  const JointHistogram table = joint_table(std::vector<double>{1, 0, 0, 0, 1, 0, 0, 0, 0}, 3, 3);
  EXPECT_EQ(std::string(measure(Measure::kMutualInformation, table).reason), kFewerSamplesThanBins);
  for (const auto estimator : kEstimators) {
    const bool made_for_few = estimator != CountEntropyOptions::Estimator::kMaximumLikelihood &&
                              estimator != CountEntropyOptions::Estimator::kMillerMadow;
    EXPECT_EQ(measure(Measure::kMutualInformation, table, with_estimator(estimator)).usable(),
              made_for_few);
  }
}

TEST(CorrectedMeasures, EntropyCorrectionsOfChiSquaredAreRejected) {
  EXPECT_FALSE(measure(Measure::kChiSquared, reference_table(),
                       with_estimator(CountEntropyOptions::Estimator::kChaoShen))
                   .usable());
  EXPECT_TRUE(measure(Measure::kChiSquared, reference_table(),
                      with_estimator(CountEntropyOptions::Estimator::kDirichlet))
                  .usable());
}

}  // namespace
}  // namespace infuse::study
