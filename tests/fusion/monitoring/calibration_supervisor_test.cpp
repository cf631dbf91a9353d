#include "fusion/monitoring/calibration_supervisor.hpp"
#include "drivers/measurement/angles.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace infuse::monitoring {
namespace {

using enum CalibrationState;
using testing::HasSubstr;

Eigen::Isometry3d turned(double degrees) {
  return geometry::exp(degrees * kDegree * geometry::Vector6::Unit(1));
}

/// Drive with steps of half a second and reports chosen by the test.
class Drive {
 public:
  explicit Drive(const SupervisorOptions& options) : supervisor(turned(0), options) {}

  MonitorReport report(Drift drift, double gain = 0, CameraFault fault = CameraFault::kNone) {
    MonitorReport report{.stamp = Stamp::from_ns(500'000'000LL * next_++), .evaluated = true};
    report.verdict.drift = drift;
    report.verdict.fault = fault;
    report.verdict.evidence = drift == Drift::kHolds ? 0 : drift == Drift::kSuspected ? 5 : 20;
    report.verdict.axis = Axis::kRotationY;
    report.verdict.offset(1) = 0.5 * kDegree;
    report.gain = gain;
    report.has_gain = supervisor.alternative().has_value();
    return report;
  }
  SupervisorActions step(Drift drift, double gain = 0, CameraFault fault = CameraFault::kNone) {
    return supervisor.process(report(drift, gain, fault), scenes);
  }
  void steps(int count, Drift drift, double gain = 0) {
    for (int k = 0; k < count; ++k) step(drift, gain);
  }
  /// Confirms a drift, starts a re-estimation and finishes it with a result of `degrees`.
  void drift_and_reestimate(double degrees) {
    steps(5, Drift::kHolds);
    EXPECT_TRUE(step(Drift::kConfirmed).start_reestimation);
    supervisor.finish_reestimation(make_result(degrees));
    steps(21, Drift::kConfirmed);
  }
  static Reestimate make_result(double degrees) {
    Reestimate result{.T_initial = turned(0), .T_camera_lidar = turned(degrees)};
    result.covariance = 1e-6 * geometry::Matrix6::Identity();
    result.moved = 1000 * degrees * kDegree;
    result.scenes = 15;
    return result;
  }

  CalibrationSupervisor supervisor;
  size_t scenes = 40;

 private:
  int next_ = 1;
};

TEST(CalibrationSupervisor, FollowsTheEvidenceWithHysteresis) {
  Drive drive({.min_scenes = 100});
  EXPECT_EQ(drive.step(Drift::kLearning).state, kMonitoring);
  EXPECT_EQ(drive.step(Drift::kHolds).state, kOk);
  EXPECT_EQ(drive.step(Drift::kSuspected).state, kSuspected);
  const SupervisorActions drifted = drive.step(Drift::kConfirmed);
  EXPECT_EQ(drifted.state, kConfirmed);
  EXPECT_TRUE(drifted.state_changed);
  EXPECT_FALSE(drifted.start_reestimation);  // too few scenes
  EXPECT_EQ(drive.step(Drift::kSuspected).state, kConfirmed);
  EXPECT_EQ(drive.step(Drift::kHolds).state, kOk);
  EXPECT_THAT(drive.supervisor.history().back().what, HasSubstr("rotation about y by +0.50"));
}

TEST(CalibrationSupervisor, AlertOnlyProposesAndTheOwnerApplies) {
  Drive drive({});
  drive.drift_and_reestimate(0.5);
  EXPECT_EQ(drive.supervisor.state(), kConfirmed);
  EXPECT_EQ(drive.supervisor.current().matrix(), turned(0).matrix());
  ASSERT_TRUE(drive.supervisor.proposal());
  const SupervisorActions decided =
      drive.supervisor.use({drive.supervisor.proposal()->T_camera_lidar}, Stamp());
  EXPECT_TRUE(decided.calibration_changed);
  EXPECT_FALSE(drive.supervisor.proposal());
  EXPECT_EQ(decided.state, kRecalibrated);
  EXPECT_EQ(drive.supervisor.current().matrix(), turned(0.5).matrix());
  drive.steps(20, Drift::kHolds, 0.01);
  EXPECT_EQ(drive.supervisor.state(), kOk);
  EXPECT_THAT(drive.supervisor.history().back().what, HasSubstr("confirmed"));
}

TEST(CalibrationSupervisor, AResultIsUsedAfterItsDelay) {
  Drive drive({.policy = UpdatePolicy::kApply, .result_delay = 3});
  drive.steps(5, Drift::kHolds);
  EXPECT_TRUE(drive.step(Drift::kConfirmed).start_reestimation);
  EXPECT_EQ(drive.supervisor.state(), kRecalibrating);
  drive.supervisor.finish_reestimation(Drive::make_result(0.5));
  for (int k = 0; k < 5; ++k) {
    EXPECT_FALSE(drive.step(Drift::kConfirmed).calibration_changed) << k;
  }
  EXPECT_TRUE(drive.step(Drift::kConfirmed).calibration_changed);
  EXPECT_EQ(drive.supervisor.state(), kRecalibrated);
  ASSERT_TRUE(drive.supervisor.covariance());
}

TEST(CalibrationSupervisor, RollsBackAWorseCalibration) {
  Drive drive({.policy = UpdatePolicy::kApply});
  drive.drift_and_reestimate(2);
  EXPECT_EQ(drive.supervisor.state(), kRecalibrated);
  ASSERT_TRUE(drive.supervisor.alternative());
  drive.steps(15, Drift::kHolds, -0.01);
  EXPECT_EQ(drive.supervisor.current().matrix(), turned(0).matrix());
  EXPECT_THAT(drive.supervisor.history().back().what, HasSubstr("rolled back"));
  EXPECT_FALSE(drive.supervisor.alternative());
}

TEST(CalibrationSupervisor, AppliesWithinItsLimitsOnly) {
  Drive near({.policy = UpdatePolicy::kApplyWithin, .limit_rotation = 0.02});
  near.drift_and_reestimate(1);
  EXPECT_EQ(near.supervisor.state(), kRecalibrated);
  Drive far({.policy = UpdatePolicy::kApplyWithin, .limit_rotation = 0.02});
  far.drift_and_reestimate(2);
  EXPECT_EQ(far.supervisor.state(), kConfirmed);
  EXPECT_TRUE(far.supervisor.proposal());
}

TEST(CalibrationSupervisor, KeepsACalibrationThatHasNotMoved) {
  Drive drive({.policy = UpdatePolicy::kApply});
  drive.steps(5, Drift::kHolds);
  drive.step(Drift::kConfirmed);
  drive.supervisor.finish_reestimation(Drive::make_result(0.05));
  drive.steps(21, Drift::kHolds);
  EXPECT_EQ(drive.supervisor.state(), kOk);
  EXPECT_EQ(drive.supervisor.current().matrix(), turned(0).matrix());
}

TEST(CalibrationSupervisor, ACameraWithAFaultIsNotRecalibrated) {
  Drive drive({.policy = UpdatePolicy::kApply});
  drive.steps(5, Drift::kHolds);
  for (int k = 0; k < 30; ++k) {
    const SupervisorActions decided = drive.step(Drift::kConfirmed, 0, CameraFault::kFrozen);
    EXPECT_FALSE(decided.start_reestimation);
    EXPECT_EQ(decided.state, kUnusable);
  }
  EXPECT_THAT(drive.supervisor.history().back().what, HasSubstr("frozen"));
  drive.steps(3, Drift::kHolds);
  EXPECT_EQ(drive.supervisor.state(), kOk);
}

TEST(CalibrationSupervisor, FailuresMakeItUnusable) {
  Drive drive({.policy = UpdatePolicy::kApply, .max_failures = 2, .retry_interval = 1});
  drive.steps(5, Drift::kHolds);
  int started = 0;
  for (int k = 0; k < 60; ++k) {
    if (!drive.step(Drift::kConfirmed).start_reestimation) continue;
    ++started;
    drive.supervisor.finish_reestimation({.reason = "not observable"});
  }
  EXPECT_EQ(started, 2);
  EXPECT_EQ(drive.supervisor.state(), kUnusable);
  // The owner may ask for another.
  drive.supervisor.request_recalibration(Stamp());
  drive.step(Drift::kConfirmed);
  EXPECT_EQ(drive.supervisor.state(), kRecalibrating);
}

TEST(CalibrationSupervisor, FrozenByTheOwnerNothingIsStarted) {
  Drive drive({.policy = UpdatePolicy::kApply});
  drive.supervisor.freeze(true, Stamp());
  drive.steps(5, Drift::kHolds);
  for (int k = 0; k < 10; ++k) EXPECT_FALSE(drive.step(Drift::kConfirmed).start_reestimation);
  EXPECT_EQ(drive.supervisor.state(), kConfirmed);
}

TEST(CalibrationSupervisor, AReestimationWaitsForScenes) {
  Drive drive({.min_scenes = 15});
  drive.scenes = 14;
  drive.steps(5, Drift::kHolds);
  for (int k = 0; k < 80; ++k) ASSERT_FALSE(drive.step(Drift::kConfirmed).start_reestimation) << k;
  drive.scenes = 15;
  EXPECT_TRUE(drive.step(Drift::kConfirmed).start_reestimation);
}

TEST(CalibrationSupervisor, FreezingCancelsTheReestimation) {
  Drive drive({.policy = UpdatePolicy::kApply});
  drive.steps(5, Drift::kHolds);
  EXPECT_TRUE(drive.step(Drift::kConfirmed).start_reestimation);
  EXPECT_TRUE(drive.supervisor.freeze(true, Stamp()).cancel_reestimation);
  EXPECT_FALSE(drive.supervisor.reestimating());
  for (int k = 0; k < 10; ++k) EXPECT_FALSE(drive.step(Drift::kConfirmed).cancel_reestimation);
  EXPECT_EQ(drive.supervisor.state(), kConfirmed);
  drive.supervisor.freeze(false, Stamp());
  EXPECT_TRUE(drive.step(Drift::kConfirmed).start_reestimation);
}

TEST(CalibrationSupervisor, ACameraFaultCancelsTheReestimation) {
  Drive drive({.policy = UpdatePolicy::kApply});
  drive.steps(5, Drift::kHolds);
  EXPECT_TRUE(drive.step(Drift::kConfirmed).start_reestimation);
  const SupervisorActions at_fault = drive.step(Drift::kConfirmed, 0, CameraFault::kDirty);
  EXPECT_TRUE(at_fault.cancel_reestimation);
  EXPECT_EQ(at_fault.state, kUnusable);
  drive.supervisor.finish_reestimation(Drive::make_result(0.5));  // too late
  drive.steps(10, Drift::kHolds);
  EXPECT_EQ(drive.supervisor.current().matrix(), turned(0).matrix());
  EXPECT_EQ(drive.supervisor.state(), kOk);
}

TEST(CalibrationSupervisor, RollingBackCancelsTheReestimation) {
  Drive drive({.policy = UpdatePolicy::kApply});
  drive.steps(5, Drift::kHolds);
  EXPECT_TRUE(drive.step(Drift::kConfirmed).start_reestimation);
  const SupervisorActions back = drive.supervisor.use({turned(1), {}, true}, Stamp());
  EXPECT_TRUE(back.cancel_reestimation);
  EXPECT_TRUE(back.calibration_changed);
  EXPECT_EQ(back.state, kMonitoring);
  EXPECT_FALSE(drive.supervisor.alternative());
  drive.supervisor.finish_reestimation(Drive::make_result(0.5));  // of another calibration
  drive.steps(30, Drift::kHolds);
  EXPECT_EQ(drive.supervisor.current().matrix(), turned(1).matrix());
}

TEST(CalibrationSupervisor, ARequestedReestimationWaitsForScenes) {
  Drive drive({.policy = UpdatePolicy::kApply});
  drive.scenes = 10;
  drive.steps(5, Drift::kHolds);
  drive.supervisor.request_recalibration(Stamp());
  EXPECT_FALSE(drive.step(Drift::kHolds).start_reestimation);
  EXPECT_TRUE(drive.supervisor.recalibration_requested());
  drive.scenes = 30;
  EXPECT_TRUE(drive.step(Drift::kHolds).start_reestimation);
  EXPECT_FALSE(drive.supervisor.recalibration_requested());
}

TEST(CalibrationSupervisor, AProposalIsMonitoredAndWithdrawn) {
  Drive drive({});
  drive.drift_and_reestimate(0.5);
  ASSERT_TRUE(drive.supervisor.alternative());
  EXPECT_EQ(drive.supervisor.alternative()->matrix(), turned(0.5).matrix());
  // The camera moves again: only scenes since then count, and another estimate follows.
  MonitorReport report = drive.report(Drift::kConfirmed);
  report.alternative_drifted = true;
  report.alternative_since = report.stamp;
  EXPECT_TRUE(drive.supervisor.process(report, 0).alternative_changed);
  EXPECT_FALSE(drive.supervisor.proposal());
  EXPECT_EQ(drive.supervisor.scenes_since(report), report.stamp);
  drive.steps(40, Drift::kConfirmed);
  EXPECT_EQ(drive.supervisor.state(), kRecalibrating);
  // The camera springs back: there is nothing to apply.
  drive.supervisor.finish_reestimation(Drive::make_result(0.7));
  drive.steps(21, Drift::kConfirmed);
  ASSERT_TRUE(drive.supervisor.proposal());
  drive.step(Drift::kHolds);
  EXPECT_EQ(drive.supervisor.state(), kOk);
  EXPECT_FALSE(drive.supervisor.proposal());
}

TEST(CalibrationSupervisor, HistoryIsBounded) {
  Drive drive({.min_scenes = 100, .max_history = 5});
  for (int k = 0; k < 20; ++k) {
    drive.step(Drift::kConfirmed);
    drive.step(Drift::kHolds);
  }
  EXPECT_EQ(drive.supervisor.history().size(), 5U);
  EXPECT_FALSE(SupervisorOptions{}.invalid());
  EXPECT_TRUE(SupervisorOptions{.min_scenes = 2}.invalid());
}

}  // namespace
}  // namespace infuse::monitoring
