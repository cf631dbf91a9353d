#include "fusion/monitoring/drift_detector.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace infuse::monitoring {
namespace {

using testing::HasSubstr;

/// Evaluations whose offsets are Gaussian around a drift; variance noise ÷ information.
class EvaluationGenerator {
 public:
  explicit EvaluationGenerator(uint64_t seed) : random_(seed) {}

  AxisEvaluation next(const PerAxis& drift, double noise, double correlation = 0) {
    AxisEvaluation evaluation;
    for (size_t k = 0; k < kAxes; ++k) {
      // Standard deviations of an evaluation: 0.17 degrees, 3 cm, 50 ms.
      const double unit = k < 3    ? 3e-3
                          : k < 6  ? 0.03
                          : k < 7  ? 0.05
                          : k < 10 ? 0.01
                          : k < 11 ? 0.1
                          : k < 14 ? 0.02
                                   : 0.04;
      evaluation.step[k] = 10 * unit;
      evaluation.curvature[k] = noise / (unit * unit);
      last_[k] = correlation * last_[k] + std::sqrt(1 - correlation * correlation) * normal();
      evaluation.slope[k] = evaluation.curvature[k] * (drift[k] + unit * last_[k]);
    }
    return evaluation;
  }

 private:
  double even() { return (static_cast<double>(random_() >> 11) + 0.5) * 0x1p-53; }
  double normal() { return std::sqrt(-2 * std::log(even())) * std::cos(2 * M_PI * even()); }
  std::mt19937_64 random_;
  PerAxis last_{};
};

/// Returns the number of evaluations until the drift is confirmed; the maximum if it never is.
int evaluations_until_confirmed(DriftDetector& test, EvaluationGenerator& generator,
                                const PerAxis& drift, int max_evaluations, double correlation = 0) {
  for (int k = 0; k < max_evaluations; ++k) {
    test.add(generator.next(drift, 0.006, correlation));
    if (test.confirmed()) return k + 1;
  }
  return max_evaluations;
}

TEST(DriftDetector, NoFalseAlarmInManyHours) {
  // 14 hours at 2 evaluations a second, then with correlated evaluations.
  for (const double correlation : {0.0, 0.4}) {
    DriftDetector test({});
    EvaluationGenerator generator(7);
    EXPECT_EQ(evaluations_until_confirmed(test, generator, {}, 100'000, correlation), 100'000);
  }
}

TEST(DriftDetector, TheBoundOnFalseAlarmsHolds) {
  // At a threshold with countable alarms: at most one an hour, with the offset at its tolerance.
  DriftDetectorOptions options;
  options.false_alarm_hours = 1;
  options.suspicion_threshold = 1;
  DriftDetector test(options);
  EvaluationGenerator generator(3);
  int alarms = 0;
  constexpr int kEvaluations = 300'000;  // 33 hours at 2.5 a second
  for (int k = 0; k < kEvaluations; ++k) {
    test.add(generator.next(options.tolerated_offset, 0.006));
    if (test.confirmed()) {
      ++alarms;
      test.restart();
    }
  }
  EXPECT_LE(alarms, 33);
}

TEST(DriftDetector, FindsADriftOfEachAxisAndSign) {
  const DriftDetectorOptions options;
  for (size_t axis = 0; axis < kAxes; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      DriftDetector test({});
      EvaluationGenerator generator(axis + 1);
      EXPECT_EQ(evaluations_until_confirmed(test, generator, {}, 200), 200);
      PerAxis drift{};
      drift[axis] = sign * 1.2 * options.drift_offset[axis];
      EXPECT_LT(evaluations_until_confirmed(test, generator, drift, 100), 60) << axis;
      EXPECT_EQ(test.strongest_axis(), static_cast<Axis>(axis));
      EXPECT_TRUE(test.suspected());
      // Mean since the drift, without the hundred seconds before.
      EXPECT_NEAR(test.offset(static_cast<Axis>(axis)), drift[axis],
                  4 * test.sigma(static_cast<Axis>(axis)));
      EXPECT_LT(test.sigma(static_cast<Axis>(axis)), 0.3 * std::abs(drift[axis]));
    }
  }
}

TEST(DriftDetector, NoAlarmBeforeTheNoiseIsLearned) {
  DriftDetector test({});
  EvaluationGenerator generator(1);
  PerAxis drift{};
  drift[0] = 0.1;
  for (int k = 0; k < 11; ++k) test.add(generator.next(drift, 0.006));
  EXPECT_FALSE(test.warmed_up());
  EXPECT_FALSE(test.suspected());
}

TEST(DriftDetector, NoisierEvaluationsCountLess) {
  // Evaluations state ten times their information.
  DriftDetector test({});
  EvaluationGenerator generator(5);
  EXPECT_EQ(evaluations_until_confirmed(test, generator, {}, 400), 400);
  DriftDetector overconfident({});
  EvaluationGenerator noisier(5);
  int alarms = 0;
  for (int k = 0; k < 20'000; ++k) {
    AxisEvaluation evaluation = noisier.next({}, 0.06);
    overconfident.add(evaluation);
    alarms += overconfident.confirmed() ? 1 : 0;
  }
  EXPECT_EQ(alarms, 0);
  EXPECT_GT(overconfident.sigma(Axis::kTranslationX), 0.5 * test.sigma(Axis::kTranslationX));
}

TEST(DriftDetector, RestartClearsEvidence) {
  DriftDetector test({});
  EvaluationGenerator generator(2);
  evaluations_until_confirmed(test, generator, {}, 50);
  PerAxis drift{};
  drift[4] = 0.1;
  evaluations_until_confirmed(test, generator, drift, 100);
  EXPECT_TRUE(test.confirmed());
  test.restart();
  EXPECT_FALSE(test.suspected());
  EXPECT_EQ(test.evidence(Axis::kTranslationY), 0);
  EXPECT_TRUE(test.warmed_up());
}

TEST(DriftDetectorOptions, SaysWhatIsWrong) {
  EXPECT_FALSE(DriftDetectorOptions{}.invalid());
  DriftDetectorOptions options;
  options.drift_offset[2] = 0;
  EXPECT_THAT(*options.invalid(), HasSubstr("drift_offset"));
  EXPECT_THAT(*(DriftDetectorOptions{.suspicion_threshold = 40}.invalid()),
              HasSubstr("suspicion_threshold"));
  EXPECT_THAT(*(DriftDetectorOptions{.warm_up = 2}.invalid()), HasSubstr("warm_up"));
  // e^h evaluations per alarm, for two parallel tests per axis.
  EXPECT_NEAR(std::exp(DriftDetectorOptions{}.confirmation_threshold()) / (2 * kAxes) / 2.5 / 3600,
              1000, 1e-6);
}

}  // namespace
}  // namespace infuse::monitoring
