#include "daemon/history/run_tracker.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>

#include "tests/faults/disk_fault.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

class RunTrackerTest : public testing::Test {
 protected:
  void TearDown() override {
    for (const int number : {SIGABRT, SIGSEGV, SIGBUS, SIGILL, SIGFPE}) signal(number, SIG_DFL);
  }

  static Stamp at_s(int64_t s) { return Stamp::from_ns((1'700'000'000 + s) * 1'000'000'000); }

  const ScratchFolder folder_;
  const std::filesystem::path file_ = folder_ / "state.json";
};

TEST_F(RunTrackerTest, RaisesNoAlertAfterACleanExit) {
  RunTracker first(file_);
  EXPECT_FALSE(first.begin_run(at_s(0)).has_value());
  first.end_run(at_s(5));
  RunTracker second(file_);
  EXPECT_FALSE(second.begin_run(at_s(6)).has_value());
  EXPECT_EQ(second.state().starts, 2U);
  EXPECT_EQ(second.state().unclean_exits, 0U);
}

TEST_F(RunTrackerTest, RaisesAnAlertAfterAnUncleanExit) {
  RunTracker(file_).begin_run(at_s(0));
  RunTracker next(file_);
  const auto alert = next.begin_run(at_s(7));
  ASSERT_TRUE(alert.has_value());
  EXPECT_TRUE(alert->raised);
  EXPECT_EQ(alert->device, "infused");
  EXPECT_EQ(
      alert->finding.what,
      "the previous run did not end by itself; it was last seen 7 s ago; unclean exits so far: 1");
  EXPECT_EQ(next.state().unclean_exits, 1U);
}

TEST_F(RunTrackerTest, AClockThatWasSetBackIsSaid) {
  RunTracker(file_).begin_run(at_s(0));
  const auto alert = RunTracker(file_).begin_run(at_s(-1'000'000));
  ASSERT_TRUE(alert.has_value());
  EXPECT_NE(alert->finding.what.find("not known when it was last seen: the clock was set back"),
            std::string::npos)
      << alert->finding.what;
}

TEST_F(RunTrackerTest, KeepsAnUnreadableStateBesideTheNew) {
  folder_.write("state.json", "{\"form\": 99}\n");
  RunTracker tracker(file_);
  EXPECT_FALSE(tracker.begin_run(at_s(0)).has_value());
  EXPECT_EQ(tracker.state().starts, 1U);
  EXPECT_EQ(folder_.read("state.json.unreadable"), "{\"form\": 99}\n");
}

TEST_F(RunTrackerTest, TheAlertNamesTheWatchdog) {
  RunTracker(file_).begin_run(at_s(0));
  folder_.write("abort_marker", "");
  const auto alert = RunTracker(file_).begin_run(at_s(3));
  ASSERT_TRUE(alert.has_value());
  EXPECT_EQ(alert->finding.what.find("the watchdog ended the previous run, which was stuck"), 0U);
  const auto next = RunTracker(file_).begin_run(at_s(4));  // the marker is reported once
  ASSERT_TRUE(next.has_value());
  EXPECT_EQ(next->finding.what.find("the previous run did not end by itself"), 0U);
}

TEST_F(RunTrackerTest, TheAlertNamesTheCrashNote) {
  EXPECT_EXIT(
      {
        RunTracker(file_).begin_run(at_s(0));
        raise(SIGSEGV);
      },
      testing::KilledBySignal(SIGSEGV), "");
  const auto alert = RunTracker(file_).begin_run(at_s(3));
  ASSERT_TRUE(alert.has_value());
  EXPECT_EQ(alert->finding.what.find("the previous run crashed (signal 11, see "), 0U)
      << alert->finding.what;
  EXPECT_TRUE(exists(folder_ / "crash-20231114-221323.txt"));
}

TEST_F(RunTrackerTest, AnAbortByAnotherProcessLeavesAMarker) {
  EXPECT_EXIT(
      {
        RunTracker(file_).begin_run(at_s(0));
        kill(getpid(), SIGABRT);
        pause();
      },
      testing::KilledBySignal(SIGABRT), "");
  EXPECT_TRUE(exists(folder_ / "abort_marker"));
}

TEST_F(RunTrackerTest, SaysWhyTheStateCannotBeWrittenUntilItCan) {
  RunTracker tracker(file_);
  tracker.begin_run(at_s(0));
  EXPECT_EQ(tracker.problem(), "");
  {
    const DiskFault fault(folder_.path(), EROFS);
    tracker.save_if_due(at_s(11));
    EXPECT_NE(tracker.problem().find("Read-only file system"), std::string::npos)
        << tracker.problem();
  }
  tracker.save_if_due(at_s(22));
  EXPECT_EQ(tracker.problem(), "");
}

TEST_F(RunTrackerTest, ACleanEndOnAFullDiskIsKnown) {
  RunTracker first(file_);
  first.begin_run(at_s(0));
  {
    const DiskFault fault(folder_.path(), ENOSPC);
    first.end_run(at_s(12));
    EXPECT_NE(first.problem(), "");
  }
  RunTracker second(file_);
  EXPECT_FALSE(second.begin_run(at_s(13)).has_value());
  EXPECT_EQ(second.state().starts, 2U);
}

}  // namespace
}  // namespace infuse::daemon
