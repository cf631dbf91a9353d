#include "fusion/watch/drift_test.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace infuse::watch {
namespace {

using testing::HasSubstr;

/// Looks whose offsets are Gaussian around a drift; variance noise ÷ information.
class Looks {
 public:
  explicit Looks(uint64_t seed) : random_(seed) {}

  AxisLook next(const PerAxis& drift, double noise, double correlation = 0) {
    AxisLook look;
    for (size_t k = 0; k < kAxes; ++k) {
      // One look tells a rotation to 0.17 degrees, a translation to 3 cm, a time to 50 ms.
      const double unit = k < 3 ? 3e-3 : k < 6 ? 0.03 : k < 7 ? 0.05 : k < 10 ? 0.01 : 0.1;
      look.step[k] = 10 * unit;
      look.bend[k] = noise / (unit * unit);
      last_[k] = correlation * last_[k] + std::sqrt(1 - correlation * correlation) * normal();
      look.slope[k] = look.bend[k] * (drift[k] + unit * last_[k]);
    }
    return look;
  }

 private:
  double even() { return (static_cast<double>(random_() >> 11) + 0.5) * 0x1p-53; }
  double normal() { return std::sqrt(-2 * std::log(even())) * std::cos(2 * M_PI * even()); }
  std::mt19937_64 random_;
  PerAxis last_{};
};

/// Looks until the test is certain; `most` where it never is.
int looks_until_certain(DriftTest& test, Looks& looks, const PerAxis& drift, int most,
                        double correlation = 0) {
  for (int k = 0; k < most; ++k) {
    test.add(looks.next(drift, 0.006, correlation));
    if (test.certain()) return k + 1;
  }
  return most;
}

TEST(DriftTest, NoFalseAlarmInManyHours) {
  // 14 hours at 2 looks a second, then with looks that depend on each other.
  for (const double correlation : {0.0, 0.4}) {
    DriftTest test({});
    Looks looks(7);
    EXPECT_EQ(looks_until_certain(test, looks, {}, 100'000, correlation), 100'000);
  }
}

TEST(DriftTest, TheBoundOnFalseAlarmsHolds) {
  // At a threshold that alarms often enough to be counted: one alarm an hour at most, with the
  // offset at the edge of what counts as kept.
  DriftTestOptions options;
  options.false_alarm_hours = 1;
  options.suspect = 1;
  DriftTest test(options);
  Looks looks(3);
  int alarms = 0;
  constexpr int kLooks = 300'000;  // 33 hours at 2.5 a second
  for (int k = 0; k < kLooks; ++k) {
    test.add(looks.next(options.kept, 0.006));
    if (test.certain()) {
      ++alarms;
      test.restart();
    }
  }
  EXPECT_LE(alarms, 33);
}

TEST(DriftTest, FindsADriftOfEachAxisAndSign) {
  const DriftTestOptions options;
  for (size_t axis = 0; axis < kAxes; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      DriftTest test({});
      Looks looks(axis + 1);
      EXPECT_EQ(looks_until_certain(test, looks, {}, 200), 200);
      PerAxis drift{};
      drift[axis] = sign * 1.2 * options.drifted[axis];
      EXPECT_LT(looks_until_certain(test, looks, drift, 100), 60) << axis;
      EXPECT_EQ(test.strongest(), static_cast<Axis>(axis));
      EXPECT_TRUE(test.suspect());
      // Of the looks since, whatever was seen during the hundred seconds before.
      EXPECT_NEAR(test.offset(static_cast<Axis>(axis)), drift[axis],
                  4 * test.deviation(static_cast<Axis>(axis)));
      EXPECT_LT(test.deviation(static_cast<Axis>(axis)), 0.3 * std::abs(drift[axis]));
    }
  }
}

TEST(DriftTest, NothingIsSaidBeforeTheNoiseIsKnown) {
  DriftTest test({});
  Looks looks(1);
  PerAxis drift{};
  drift[0] = 0.1;
  for (int k = 0; k < 11; ++k) test.add(looks.next(drift, 0.006));
  EXPECT_FALSE(test.warmed_up());
  EXPECT_FALSE(test.suspect());
}

TEST(DriftTest, NoisierLooksAreLearnedToBeWorthLess) {
  // Looks claim to be worth ten times what they are.
  DriftTest test({});
  Looks looks(5);
  EXPECT_EQ(looks_until_certain(test, looks, {}, 400), 400);
  DriftTest boastful({});
  Looks same(5);
  int alarms = 0;
  for (int k = 0; k < 20'000; ++k) {
    AxisLook look = same.next({}, 0.06);
    boastful.add(look);
    alarms += boastful.certain() ? 1 : 0;
  }
  EXPECT_EQ(alarms, 0);
  EXPECT_GT(boastful.deviation(Axis::kX), 0.5 * test.deviation(Axis::kX));
}

TEST(DriftTest, RestartForgetsEvidence) {
  DriftTest test({});
  Looks looks(2);
  looks_until_certain(test, looks, {}, 50);
  PerAxis drift{};
  drift[4] = 0.1;
  looks_until_certain(test, looks, drift, 100);
  EXPECT_TRUE(test.certain());
  test.restart();
  EXPECT_FALSE(test.suspect());
  EXPECT_EQ(test.evidence(Axis::kY), 0);
  EXPECT_TRUE(test.warmed_up());
}

TEST(DriftTestOptions, SaysWhatIsWrong) {
  EXPECT_FALSE(DriftTestOptions{}.invalid());
  DriftTestOptions options;
  options.drifted[2] = 0;
  EXPECT_THAT(*options.invalid(), HasSubstr("drifted"));
  EXPECT_THAT(*(DriftTestOptions{.suspect = 40}.invalid()), HasSubstr("suspect"));
  EXPECT_THAT(*(DriftTestOptions{.warm_up = 2}.invalid()), HasSubstr("warm_up"));
  // e^h looks an alarm, for two tests an axis side by side.
  EXPECT_NEAR(std::exp(DriftTestOptions{}.certain()) / (2 * kAxes) / 2.5 / 3600, 1000, 1e-6);
}

}  // namespace
}  // namespace infuse::watch
