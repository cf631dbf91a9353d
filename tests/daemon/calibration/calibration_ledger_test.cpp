#include "daemon/calibration/calibration_ledger.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <fstream>
#include <random>

namespace infuse::daemon {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using Op = Request::Op;

Eigen::Isometry3d at(double x) { return Eigen::Isometry3d(Eigen::Translation3d(x, 0, 0)); }

class CalibrationLedgerTest : public testing::Test {
 protected:
  CalibrationLedgerTest() { std::filesystem::create_directories(folder_); }
  ~CalibrationLedgerTest() override { std::filesystem::remove_all(folder_); }

  static Rig rig(double x) {
    Rig rig;
    rig.lidars.push_back({.name = "top"});
    rig.cameras.push_back({.name = "front", .lidar = "top", .T_camera_lidar = at(x)});
    rig.cameras.push_back({.name = "rear", .lidar = "top"});
    return rig;
  }

  static CalibrationReport report(double x, uint64_t decision = 0) {
    CalibrationReport report;
    report.camera = "front";
    report.stamp = Stamp::from_ns(42);
    report.T_camera_lidar = at(x);
    report.decision = decision;
    return report;
  }

  /// The x of the front camera that a new run starts with.
  double restarted(double configured) {
    Rig next = rig(configured);
    CalibrationLedger(path_).restore(next);
    return next.cameras[0].T_camera_lidar.translation().x();
  }

  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("infuse-saved-" + std::to_string(::getpid()));
  std::filesystem::path path_ = folder_ / "calibrations.json";
};

TEST_F(CalibrationLedgerTest, WhatTheDaemonAppliedIsNumberedAndInUseAfterARestart) {
  Rig first = rig(0.1);
  CalibrationLedger ledger(path_);
  EXPECT_TRUE(ledger.restore(first).empty());
  CalibrationReport applied = report(0.15);
  applied.estimate.emplace();
  applied.estimate->T_camera_lidar = at(0.15);
  applied.estimate->T_estimated_from = at(0.1);
  ASSERT_TRUE(ledger.observe(applied));
  ASSERT_EQ(applied.known.size(), 2U);
  EXPECT_EQ(applied.known[0].use, CalibrationUse::kPrevious);
  EXPECT_EQ(applied.known[1].use, CalibrationUse::kInUse);
  EXPECT_EQ(applied.known[1].number, 3U);  // 2 is that of the rear camera
  EXPECT_EQ(applied.known[1].estimated_from, 1U);
  EXPECT_EQ(restarted(0.1), 0.15);
  // Put back by the guard, after its probation: the number that it had.
  CalibrationReport back = report(0.1);
  ASSERT_TRUE(ledger.observe(back));
  EXPECT_EQ(back.known.size(), 2U);
  EXPECT_EQ(back.known[0].use, CalibrationUse::kInUse);
  EXPECT_EQ(restarted(0.1), 0.1);
}

TEST_F(CalibrationLedgerTest, ADecisionIsInTheFileBeforeItIsReturned) {
  Rig first = rig(0.1);
  CalibrationLedger ledger(path_);
  ledger.restore(first);
  EXPECT_THAT(ledger.decide({.op = Op::kApply}).error().what, HasSubstr("no new calibration"));
  EXPECT_THAT(ledger.decide({.op = Op::kRollback}).error().what, HasSubstr("no calibration"));
  CalibrationReport proposed = report(0.1);
  proposed.proposal.emplace();
  proposed.proposal->T_camera_lidar = at(0.2);
  ASSERT_TRUE(ledger.observe(proposed));
  EXPECT_EQ(restarted(0.1), 0.1);

  const auto applied = ledger.decide({.op = Op::kApply});
  ASSERT_TRUE(applied);
  EXPECT_EQ(restarted(0.1), 0.2);
  ASSERT_EQ(applied->commands.size(), 1U);
  EXPECT_EQ(applied->commands[0].camera, "front");
  EXPECT_EQ(applied->commands[0].calibration.T_camera_lidar.translation().x(), 0.2);
  EXPECT_FALSE(applied->commands[0].calibration.rolls_back);
  // A report of before the guard has heard of it changes nothing.
  CalibrationReport late = report(0.1);
  ASSERT_TRUE(ledger.observe(late));
  EXPECT_EQ(restarted(0.1), 0.2);
  CalibrationReport done = report(0.2, applied->commands[0].decision);
  ASSERT_TRUE(ledger.observe(done));

  const auto back = ledger.decide({.op = Op::kRollback, .device = "front"});
  ASSERT_TRUE(back);
  EXPECT_TRUE(back->commands[0].calibration.rolls_back);
  EXPECT_EQ(restarted(0.1), 0.1);
}

TEST_F(CalibrationLedgerTest, AnyEarlierOrGivenCalibrationCanBeAppliedAlsoAfterARestart) {
  {
    Rig first = rig(0.1);
    CalibrationLedger ledger(path_);
    ledger.restore(first);
    for (const double x : {0.2, 0.3}) {
      ASSERT_TRUE(ledger.decide({.op = Op::kApply, .device = "front", .T_camera_lidar = at(x)}));
    }
  }
  Rig second = rig(0.1);
  CalibrationLedger ledger(path_);
  EXPECT_THAT(ledger.restore(second), ElementsAre(HasSubstr("saved calibration 4")));
  EXPECT_THAT(ledger.decide({.op = Op::kApply, .number = 4}).error().what, HasSubstr("is in use"));
  EXPECT_THAT(ledger.decide({.op = Op::kApply, .number = 9}).error().what, HasSubstr("number 9"));
  const auto unknown = ledger.decide({.op = Op::kApply, .device = "side"});
  EXPECT_THAT(unknown.error().message(), HasSubstr("known: front rear"));
  const auto applied = ledger.decide({.op = Op::kApply, .number = 3});
  ASSERT_TRUE(applied);
  EXPECT_EQ(applied->commands[0].camera, "front");
  EXPECT_EQ(restarted(0.1), 0.2);
  ASSERT_TRUE(ledger.decide({.op = Op::kRollback}));
  EXPECT_EQ(restarted(0.1), 0.3);
}

TEST_F(CalibrationLedgerTest, ARequestedReestimationIsAnsweredHonestly) {
  Rig first = rig(0.1);
  CalibrationLedger ledger(path_);
  ledger.restore(first);
  const Request request{.op = Op::kRecalibrate, .device = "front"};
  EXPECT_THAT(ledger.decide(request)->note, HasSubstr("waits for images"));
  CalibrationReport observed = report(0.1);
  observed.scenes = 12;
  observed.needed_scenes = 30;
  ASSERT_TRUE(ledger.observe(observed));
  EXPECT_THAT(ledger.decide(request)->note, HasSubstr("30 scenes are stored, 12 now"));
  observed.verdict.fault = monitoring::CameraFault::kDirty;
  ASSERT_TRUE(ledger.observe(observed));
  EXPECT_THAT(ledger.decide(request).error().what, HasSubstr("dirty"));
}

TEST_F(CalibrationLedgerTest, WhatCouldNotBeWrittenIsNotDecidedOrWrittenLater) {
  Rig first = rig(0.1);
  CalibrationLedger ledger(path_);
  ledger.restore(first);
  std::filesystem::remove_all(folder_);
  std::ofstream(folder_) << "a file in place of the folder";
  CalibrationReport applied = report(0.15);
  EXPECT_FALSE(ledger.observe(applied));
  EXPECT_FALSE(ledger.decide({.op = Op::kRollback}));
  EXPECT_FALSE(ledger.decide({.op = Op::kFreeze, .device = "rear"}));
  std::filesystem::remove(folder_);
  EXPECT_TRUE(ledger.observe(applied));
  EXPECT_EQ(restarted(0.1), 0.15);
  EXPECT_TRUE(ledger.restore_commands().empty());
}

TEST_F(CalibrationLedgerTest, AFrozenCalibrationIsFrozenAfterARestart) {
  Rig first = rig(0.1);
  CalibrationLedger ledger(path_);
  ledger.restore(first);
  ASSERT_TRUE(ledger.decide({.op = Op::kFreeze, .device = "front"}));
  Rig second = rig(0.1);
  CalibrationLedger again(path_);
  EXPECT_THAT(again.restore(second), ElementsAre(HasSubstr("frozen")));
  ASSERT_EQ(again.restore_commands().size(), 1U);
  EXPECT_EQ(again.restore_commands()[0].camera, "front");
  ASSERT_TRUE(again.decide({.op = Op::kFreeze, .on = false}));
  EXPECT_TRUE(again.restore_commands().empty());
}

TEST_F(CalibrationLedgerTest, TheOldestWithoutAUseIsForgotten) {
  Rig first = rig(0);
  CalibrationLedger ledger(path_);
  ledger.restore(first);
  CalibrationReport last;
  for (int k = 1; k <= 40; ++k) {
    last = report(0.01 * k);
    ASSERT_TRUE(ledger.observe(last));
  }
  EXPECT_EQ(last.known.size(), CalibrationLedger::kMaxKept);
  EXPECT_EQ(last.known.back().number, 42U);
  EXPECT_TRUE(ledger.decide({.op = Op::kRollback}));
  EXPECT_NEAR(restarted(0), 0.39, 1e-12);
}

TEST_F(CalibrationLedgerTest, TheFileOfTheReleaseBeforeIsRead) {
  std::ofstream(path_) << R"({"form": 1, "cameras": [{"camera": "front", "since_ns": 5,
    "T_camera_lidar_configured": [1,0,0,0.1, 0,1,0,0, 0,0,1,0, 0,0,0,1],
    "T_camera_lidar": [1,0,0,0.2, 0,1,0,0, 0,0,1,0, 0,0,0,1]}]})";
  Rig first = rig(0.1);
  CalibrationLedger ledger(path_);
  ledger.restore(first);
  EXPECT_FALSE(ledger.damage());
  EXPECT_EQ(first.cameras[0].T_camera_lidar.translation().x(), 0.2);
  ASSERT_TRUE(ledger.decide({.op = Op::kRollback}));
  EXPECT_EQ(restarted(0.1), 0.1);
}

TEST_F(CalibrationLedgerTest, AFileOfAnotherReleaseIsKeptAndNamed) {
  const std::string newer = "{\"form\": 3, \"cameras\": []}\n";
  std::ofstream(path_) << newer;
  Rig first = rig(0.1);
  CalibrationLedger ledger(path_);
  ledger.restore(first);
  ASSERT_TRUE(ledger.damage());
  EXPECT_THAT(*ledger.damage(), HasSubstr("not a calibration file of this release"));
  CalibrationReport applied = report(0.2);
  ASSERT_TRUE(ledger.observe(applied));
  std::ifstream kept(path_.string() + ".unreadable");
  EXPECT_EQ((std::string{std::istreambuf_iterator<char>(kept), {}}), newer);
  EXPECT_EQ(restarted(0.1), 0.2);
}

TEST_F(CalibrationLedgerTest, AChangedConfigurationTakesPrecedence) {
  Rig first = rig(0.1);
  CalibrationLedger ledger(path_);
  ledger.restore(first);
  CalibrationReport applied = report(0.15);
  ASSERT_TRUE(ledger.observe(applied));
  Rig other = rig(0.3);
  CalibrationLedger again(path_);
  EXPECT_THAT(again.restore(other).at(0), HasSubstr("configured calibration, which has changed"));
  EXPECT_EQ(other.cameras[0].T_camera_lidar.translation().x(), 0.3);
  ASSERT_TRUE(again.decide({.op = Op::kRollback}));
  EXPECT_EQ(restarted(0.3), 0.15);
}

TEST_F(CalibrationLedgerTest, DamagedFilesAreReportedAndLeaveTheConfiguration) {
  Rig first = rig(0.1);
  CalibrationLedger ledger(path_);
  ledger.restore(first);
  CalibrationReport applied = report(0.15);
  ASSERT_TRUE(ledger.observe(applied));
  std::ifstream file(path_);
  const std::string whole{std::istreambuf_iterator<char>(file), {}};
  std::mt19937 random(1);
  for (int i = 0; i < 300; ++i) {
    std::string text = whole.substr(0, random() % whole.size());
    if (i % 2 == 1) {
      text = whole;
      text[random() % text.size()] = static_cast<char>(random());
    }
    std::ofstream(path_) << text;
    Rig rig = this->rig(0.1);
    CalibrationLedger(path_).restore(rig);
    const Eigen::Isometry3d& T = rig.cameras[0].T_camera_lidar;
    ASSERT_NEAR((T.linear() * T.linear().transpose() - Eigen::Matrix3d::Identity()).norm(), 0,
                1e-6);
    ASSERT_TRUE(T.translation().allFinite());
  }
}

}  // namespace
}  // namespace infuse::daemon
