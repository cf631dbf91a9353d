#include "fusion/watch/decision.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace infuse::watch {
namespace {

using enum CalibrationState;
using testing::HasSubstr;

Eigen::Isometry3d turned(double degrees) {
  return geometry::exp(degrees * M_PI / 180 * geometry::Vector6::Unit(1));
}

/// A drive of half a second a step, in which the test chooses what the watch says.
class Drive {
 public:
  explicit Drive(const DecisionOptions& options) : decision(turned(0), options) {}

  Decided step(Drift drift, double gain = 0, CameraFault fault = CameraFault::kNone) {
    WatchReport report{.stamp = Stamp::from_ns(500'000'000LL * next_++), .looked = true};
    report.drift = drift;
    report.fault = fault;
    report.evidence = drift == Drift::kHolds ? 0 : drift == Drift::kSuspect ? 5 : 20;
    report.axis = Axis::kRotationY;
    report.offset(1) = 0.5 * M_PI / 180;
    report.gain = gain;
    report.has_gain = decision.alternative().has_value();
    return decision.take(report, scenes);
  }
  void steps(int count, Drift drift, double gain = 0) {
    for (int k = 0; k < count; ++k) step(drift, gain);
  }
  /// Drifts, starts and delivers `degrees`.
  void drift_and_find(double degrees) {
    steps(5, Drift::kHolds);
    EXPECT_TRUE(step(Drift::kDrifted).start);
    decision.finish(found(degrees));
    steps(21, Drift::kDrifted);
  }
  static Reestimate found(double degrees) {
    Reestimate result{.T_camera_lidar = turned(degrees)};
    result.covariance = 1e-6 * geometry::Matrix6::Identity();
    result.moved = 1000 * degrees * M_PI / 180;
    result.scenes = 15;
    return result;
  }

  Decision decision;
  size_t scenes = 40;

 private:
  int next_ = 1;
};

TEST(Decision, FollowsTheEvidenceWithHysteresis) {
  Drive drive({.scenes = 100, .patience = 1000});
  EXPECT_EQ(drive.step(Drift::kLearning).state, kWatching);
  EXPECT_EQ(drive.step(Drift::kHolds).state, kOk);
  EXPECT_EQ(drive.step(Drift::kSuspect).state, kSuspect);
  const Decided drifted = drive.step(Drift::kDrifted);
  EXPECT_EQ(drifted.state, kDrifted);
  EXPECT_TRUE(drifted.changed);
  EXPECT_FALSE(drifted.start);  // too few scenes
  EXPECT_EQ(drive.step(Drift::kSuspect).state, kDrifted);
  EXPECT_EQ(drive.step(Drift::kHolds).state, kOk);
  EXPECT_THAT(drive.decision.history().back().what, HasSubstr("rotation about y, 0.50 degrees"));
}

TEST(Decision, AlertOnlyProposesAndTheOwnerApplies) {
  Drive drive({});
  drive.drift_and_find(0.5);
  EXPECT_EQ(drive.decision.state(), kDrifted);
  EXPECT_EQ(drive.decision.present().matrix(), turned(0).matrix());
  ASSERT_TRUE(drive.decision.proposal());
  drive.decision.apply();
  const Decided decided = drive.step(Drift::kDrifted);
  EXPECT_TRUE(decided.calibration_changed);
  EXPECT_EQ(decided.state, kRecalibrated);
  EXPECT_EQ(drive.decision.present().matrix(), turned(0.5).matrix());
  drive.steps(20, Drift::kHolds, 0.01);
  EXPECT_EQ(drive.decision.state(), kOk);
  EXPECT_THAT(drive.decision.history().back().what, HasSubstr("confirmed"));
}

TEST(Decision, AResultBecomesVisibleAfterItsBudget) {
  Drive drive({.policy = Policy::kApply, .budget = 3});
  drive.steps(5, Drift::kHolds);
  EXPECT_TRUE(drive.step(Drift::kDrifted).start);
  EXPECT_EQ(drive.decision.state(), kRecalibrating);
  drive.decision.finish(Drive::found(0.5));
  for (int k = 0; k < 5; ++k) {
    EXPECT_FALSE(drive.step(Drift::kDrifted).calibration_changed) << k;
  }
  EXPECT_TRUE(drive.step(Drift::kDrifted).calibration_changed);
  EXPECT_EQ(drive.decision.state(), kRecalibrated);
  ASSERT_TRUE(drive.decision.covariance());
}

TEST(Decision, RollsBackWhatDoesNotHoldUp) {
  Drive drive({.policy = Policy::kApply});
  drive.drift_and_find(2);
  EXPECT_EQ(drive.decision.state(), kRecalibrated);
  ASSERT_TRUE(drive.decision.alternative());
  drive.steps(15, Drift::kHolds, -0.01);
  EXPECT_EQ(drive.decision.present().matrix(), turned(0).matrix());
  EXPECT_THAT(drive.decision.history().back().what, HasSubstr("rolled back"));
  EXPECT_FALSE(drive.decision.alternative());
}

TEST(Decision, AppliesWithinItsLimitsOnly) {
  Drive near({.policy = Policy::kApplyWithin, .limit_rotation = 0.02});
  near.drift_and_find(1);
  EXPECT_EQ(near.decision.state(), kRecalibrated);
  Drive far({.policy = Policy::kApplyWithin, .limit_rotation = 0.02});
  far.drift_and_find(2);
  EXPECT_EQ(far.decision.state(), kDrifted);
  EXPECT_TRUE(far.decision.proposal());
}

TEST(Decision, WhatHasNotMovedIsKept) {
  Drive drive({.policy = Policy::kApply});
  drive.steps(5, Drift::kHolds);
  drive.step(Drift::kDrifted);
  drive.decision.finish(Drive::found(0.05));
  drive.steps(21, Drift::kHolds);
  EXPECT_EQ(drive.decision.state(), kOk);
  EXPECT_EQ(drive.decision.present().matrix(), turned(0).matrix());
}

TEST(Decision, ACameraAtFaultIsNotRecalibrated) {
  Drive drive({.policy = Policy::kApply});
  drive.steps(5, Drift::kHolds);
  for (int k = 0; k < 30; ++k) {
    const Decided decided = drive.step(Drift::kDrifted, 0, CameraFault::kFrozen);
    EXPECT_FALSE(decided.start);
    EXPECT_EQ(decided.state, kUnusable);
  }
  EXPECT_THAT(drive.decision.history().back().what, HasSubstr("frozen"));
  drive.steps(3, Drift::kHolds);
  EXPECT_EQ(drive.decision.state(), kOk);
}

TEST(Decision, FailuresMakeItUnusable) {
  Drive drive({.policy = Policy::kApply, .failures = 2, .retry = 1});
  drive.steps(5, Drift::kHolds);
  int started = 0;
  for (int k = 0; k < 60; ++k) {
    if (!drive.step(Drift::kDrifted).start) continue;
    ++started;
    Reestimate failed;
    failed.reason = "not observable";
    drive.decision.finish(failed);
  }
  EXPECT_EQ(started, 2);
  EXPECT_EQ(drive.decision.state(), kUnusable);
}

TEST(Decision, FrozenByTheOwnerNothingIsStarted) {
  Drive drive({.policy = Policy::kApply});
  drive.decision.freeze(true);
  drive.steps(5, Drift::kHolds);
  for (int k = 0; k < 10; ++k) EXPECT_FALSE(drive.step(Drift::kDrifted).start);
  EXPECT_EQ(drive.decision.state(), kDrifted);
}

TEST(Decision, FewerScenesAreEnoughWhereMoreDoNotCome) {
  Drive drive({.scenes = 30, .least_scenes = 15, .patience = 40});
  drive.scenes = 20;
  drive.steps(5, Drift::kHolds);
  for (int k = 0; k < 80; ++k) ASSERT_FALSE(drive.step(Drift::kDrifted).start) << k;
  EXPECT_TRUE(drive.step(Drift::kDrifted).start);
}

TEST(Decision, FreezingGivesUpWhatIsBeingReestimated) {
  Drive drive({.policy = Policy::kApply});
  drive.steps(5, Drift::kHolds);
  EXPECT_TRUE(drive.step(Drift::kDrifted).start);
  drive.decision.freeze(true);
  const Decided frozen = drive.step(Drift::kDrifted);
  EXPECT_TRUE(frozen.cancel);
  EXPECT_EQ(frozen.state, kDrifted);
  EXPECT_FALSE(drive.decision.running());
  for (int k = 0; k < 10; ++k) EXPECT_FALSE(drive.step(Drift::kDrifted).cancel);
  drive.decision.freeze(false);
  EXPECT_TRUE(drive.step(Drift::kDrifted).start);
}

TEST(Decision, ACameraAtFaultEndsWhatIsBeingReestimated) {
  Drive drive({.policy = Policy::kApply});
  drive.steps(5, Drift::kHolds);
  EXPECT_TRUE(drive.step(Drift::kDrifted).start);
  const Decided at_fault = drive.step(Drift::kDrifted, 0, CameraFault::kDirty);
  EXPECT_TRUE(at_fault.cancel);
  EXPECT_EQ(at_fault.state, kUnusable);
  drive.decision.finish(Drive::found(0.5));  // too late
  drive.steps(10, Drift::kHolds);
  EXPECT_EQ(drive.decision.present().matrix(), turned(0).matrix());
  EXPECT_EQ(drive.decision.state(), kOk);
}

TEST(Decision, GoingBackGivesUpWhatIsBeingReestimated) {
  Drive drive({.policy = Policy::kApply, .retry = 0});
  drive.drift_and_find(0.5);
  drive.decision.recalibrate();
  EXPECT_TRUE(drive.step(Drift::kHolds).start);
  drive.decision.roll_back();
  const Decided back = drive.step(Drift::kHolds);
  EXPECT_TRUE(back.cancel);
  EXPECT_TRUE(back.calibration_changed);
}

TEST(Decision, TheOwnerMayAskAndRollBack) {
  Drive drive({.policy = Policy::kApply});
  drive.steps(5, Drift::kHolds);
  drive.decision.recalibrate();
  EXPECT_TRUE(drive.step(Drift::kHolds).start);
  drive.decision.finish(Drive::found(0.5));
  drive.steps(21, Drift::kHolds);
  EXPECT_EQ(drive.decision.present().matrix(), turned(0.5).matrix());
  drive.decision.roll_back();
  EXPECT_TRUE(drive.step(Drift::kHolds).calibration_changed);
  EXPECT_EQ(drive.decision.present().matrix(), turned(0).matrix());
}

TEST(Decision, HistoryIsBounded) {
  Drive drive({.scenes = 100, .patience = 1000, .history = 5});
  for (int k = 0; k < 20; ++k) {
    drive.step(Drift::kDrifted);
    drive.step(Drift::kHolds);
  }
  EXPECT_EQ(drive.decision.history().size(), 5U);
  EXPECT_FALSE(DecisionOptions{}.invalid());
  EXPECT_TRUE(DecisionOptions{.least_scenes = 1}.invalid());
  EXPECT_STREQ(to_string(kRecalibrating), "RECALIBRATING");
}

}  // namespace
}  // namespace infuse::watch
