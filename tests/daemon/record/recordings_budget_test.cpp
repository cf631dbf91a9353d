#include "daemon/record/recordings_budget.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/daemon/pipeline/run_replay.hpp"

namespace infuse::daemon {
namespace {

class RecordingsBudgetTest : public testing::Test {
 protected:
  /// A drive of 1000 bytes, in two files.
  void make_drive(const std::string& name) {
    std::filesystem::create_directories(folder_ / name / "camera_0");
    std::ofstream(folder_ / name / "drive.toml") << std::string(400, 'x');
    std::ofstream(folder_ / name / "camera_0" / "1.jpg") << std::string(600, 'x');
  }
  bool exists(const char* name) { return std::filesystem::exists(folder_ / name); }

  TemporaryFolder folder_;
};

TEST_F(RecordingsBudgetTest, TheOldestAlertsMakeRoom) {
  for (const char* name : {"alert-20260101-a", "alert-20260102-b", "alert-20260103-c", "mine"}) {
    make_drive(name);
  }
  RecordingsBudget budget(folder_ / "", 5000);
  budget.measure("new");
  EXPECT_TRUE(budget.make_room(1000));
  EXPECT_TRUE(exists("alert-20260101-a"));
  EXPECT_TRUE(budget.make_room(2500));
  EXPECT_FALSE(exists("alert-20260101-a"));
  EXPECT_FALSE(exists("alert-20260102-b"));
  EXPECT_TRUE(exists("alert-20260103-c"));
}

TEST_F(RecordingsBudgetTest, RequestedRecordingsAreNeverRemoved) {
  for (const char* name : {"alert-20260101-a", "mine", "yours"}) make_drive(name);
  RecordingsBudget budget(folder_ / "", 2500);
  budget.measure("new");
  EXPECT_TRUE(budget.make_room(500));
  EXPECT_FALSE(budget.make_room(501));
  EXPECT_FALSE(exists("alert-20260101-a"));
  EXPECT_TRUE(exists("mine"));
  EXPECT_TRUE(exists("yours"));
}

TEST_F(RecordingsBudgetTest, TheDrivesOfTheCurrentRecordingAreItsOwn) {
  for (const char* name : {"alert-20260101-a", "alert-20260101-a.2", "alert-20260102-b"}) {
    make_drive(name);
  }
  RecordingsBudget budget(folder_ / "", 2000);
  budget.measure("alert-20260101-a");
  EXPECT_FALSE(budget.make_room(2500));
  EXPECT_TRUE(exists("alert-20260101-a"));
  EXPECT_TRUE(exists("alert-20260101-a.2"));
  EXPECT_FALSE(exists("alert-20260102-b"));
}

// A computer without a battery, whose clock begins in the past.
TEST_F(RecordingsBudgetTest, AfterAClockThatWasSetBackTheNewAlertsStay) {
  for (const char* name : {"alert-20260101-a", "alert-20260102-b", "alert-19700101-c"}) {
    make_drive(name);
  }
  RecordingsBudget budget(folder_ / "", 3000);
  budget.measure("alert-19700102-d");
  EXPECT_TRUE(budget.make_room(1000));
  EXPECT_FALSE(exists("alert-20260101-a"));
  EXPECT_TRUE(exists("alert-20260102-b"));
  EXPECT_TRUE(exists("alert-19700101-c"));
  make_drive("alert-19700102-d");
  remove_old_alerts(folder_ / "", 2, "alert-19700102-d");
  EXPECT_FALSE(exists("alert-20260102-b"));
  EXPECT_TRUE(exists("alert-19700101-c"));
  EXPECT_TRUE(exists("alert-19700102-d"));
}

TEST_F(RecordingsBudgetTest, AMissingFolderIsEmpty) {
  RecordingsBudget budget(folder_ / "missing", 100);
  budget.measure("new");
  EXPECT_TRUE(budget.make_room(100));
}

}  // namespace
}  // namespace infuse::daemon
