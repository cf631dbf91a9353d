#include "daemon/record/recording.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <csignal>
#include <random>
#include <thread>

#include "daemon/record/recorder.hpp"
#include "drivers/recording/drive_source.hpp"
#include "tests/daemon/pipeline/run_replay.hpp"
#include "tests/daemon/record/recording_fixture.hpp"

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

TEST_F(RecordingTest, EndsAtItsLimits) {
  plan_.max_duration = std::chrono::milliseconds(10);
  Recording by_time = begin();
  for (uint32_t i = 0; i < 20; ++i) add_datagram(by_time, i, i * 1'000'000);
  EXPECT_TRUE(by_time.report().ended);
  EXPECT_FALSE(by_time.report().failed);
  EXPECT_THAT(by_time.report().reason, HasSubstr("duration"));
  events("d");
  EXPECT_EQ(numbers_.size(), 11U);

  plan_.name = "e";
  plan_.max_duration = from_seconds(100);
  plan_.max_bytes = 100'000;
  Recording by_size = begin();
  for (uint32_t i = 0; i < 200; ++i) add_datagram(by_size, i, i * 1'000);
  EXPECT_TRUE(by_size.report().ended);
  EXPECT_THAT(by_size.report().reason, HasSubstr("size"));
  EXPECT_LT(by_size.report().bytes, 102'000U);
  EXPECT_EQ(std::filesystem::file_size(plan_.directory / "e" / "lidar.pcap") +
                std::filesystem::file_size(plan_.directory / "e" / "vehicle.dbc") +
                std::filesystem::file_size(plan_.directory / "e" / "gnss.csv") +
                std::filesystem::file_size(plan_.directory / "e" / "camera_left/times.csv") +
                std::filesystem::file_size(plan_.directory / "e" / "camera_right/times.csv"),
            by_size.report().bytes);
}

TEST_F(RecordingTest, NeverOverwritesAnExistingDrive) {
  Recording first = begin();
  const auto second = Recording::begin(plan_, Stamp::from_ns(kStart));
  ASSERT_FALSE(second.has_value());
  EXPECT_THAT(second.error().message(), HasSubstr("already exists"));
}

TEST_F(RecordingTest, KeepsTheMinimumFreeSpace) {
  plan_.min_free_bytes = uint64_t{1} << 62;
  const auto refused = Recording::begin(plan_, Stamp::from_ns(kStart));
  ASSERT_FALSE(refused.has_value());
  EXPECT_THAT(refused.error().message(), HasSubstr("required"));
  EXPECT_FALSE(std::filesystem::exists(plan_.directory / "d"));
}

/// Limits the file size of this process, to simulate a disk that fills in the middle of a record.
class FileLimit {
 public:
  explicit FileLimit(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileLimit() { setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

TEST_F(RecordingTest, AFullDiskEndsTheRecordingAndLeavesAValidDrive) {
  Recording recording = begin();
  {
    const FileLimit limit(50'123);
    for (uint32_t i = 0; i < 1000 && !recording.report().ended; ++i) {
      add_datagram(recording, i, i * 1'000);
      if (i % 7 == 0) recording.flush_and_check(Stamp::from_ns(kStart), 0, true);
    }
  }
  EXPECT_TRUE(recording.report().ended);
  EXPECT_TRUE(recording.report().failed);
  EXPECT_THAT(recording.report().reason, HasSubstr("is the disk full?"));
  events("d");
  EXPECT_TRUE(notes_.empty()) << notes_[0].message();
  EXPECT_GT(numbers_.size(), 25U);  // 39 fit
  for (uint32_t i = 0; i < numbers_.size(); ++i) EXPECT_EQ(numbers_[i], i);
}

TEST_F(RecordingTest, AFullDiskLeavesNoPartialCanLine) {
  Recording recording = begin();
  {
    const FileLimit limit(3'333);
    vehicle::CanFrame frame;
    frame.length = 8;
    for (int i = 0; i < 1000 && !recording.report().ended; ++i) {
      frame.stamp = Stamp::from_ns(kStart + i * 1'000);
      add(recording, i * 1'000, RecordKind::kCanFrame, body_of(frame));
      if (i % 5 == 4) recording.flush_and_check(Stamp::from_ns(kStart), 0, true);
    }
  }
  EXPECT_TRUE(recording.report().failed);
  events("d");
  EXPECT_GT(lines_.size(), 60U);
  for (const std::string& line : lines_) EXPECT_EQ(line.size(), lines_[0].size());
}

// Killed at any moment, what was handed to the system is a drive.
TEST_F(RecordingTest, ADriveIsValidWheneverTheProcessIsKilled) {
  std::mt19937 random(11);
  const std::vector<uint8_t> grey(48, 77);
  for (int round = 0; round < 12; ++round) {
    plan_.name = "k" + std::to_string(round);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      auto recording = Recording::begin(plan_, Stamp::from_ns(kStart));
      for (uint32_t i = 0;; ++i) {
        add_datagram(*recording, i, i * 1'000);
        add_image(*recording, 0, i, camera::RawFormat::kGrey, grey, 8, i * 1'000);
        if (i % 16 == 0) recording->flush_and_check(Stamp::from_ns(kStart), 0, true);
      }
    }
    while (!std::filesystem::exists(plan_.directory / plan_.name / "camera_left/000001.png")) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 5000));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    numbers_.clear();
    files_.clear();
    const auto all = events(plan_.name);
    for (uint32_t i = 0; i < numbers_.size(); ++i) EXPECT_EQ(numbers_[i], i);
    for (const auto& file : files_) EXPECT_GT(std::filesystem::file_size(file), 60U);
    EXPECT_GT(all.size(), 0U);
  }
}

TEST(Recorder, KeepsTheNewestAlertRecordings) {
  TemporaryFolder folder;
  for (const char* name :
       {"alert-20260101-a", "alert-20260102-b", "alert-20260102-b.2", "alert-20260103-c", "mine"}) {
    std::filesystem::create_directories(folder / name / "camera_0");
  }
  remove_old_alerts(folder / "", 2, "");
  EXPECT_FALSE(std::filesystem::exists(folder / "alert-20260101-a"));
  EXPECT_TRUE(std::filesystem::exists(folder / "alert-20260102-b.2"));
  EXPECT_TRUE(std::filesystem::exists(folder / "alert-20260103-c"));
  EXPECT_TRUE(std::filesystem::exists(folder / "mine"));
  remove_old_alerts(folder / "", 1, "");
  EXPECT_FALSE(std::filesystem::exists(folder / "alert-20260102-b"));
  EXPECT_FALSE(std::filesystem::exists(folder / "alert-20260102-b.2"));
}

}  // namespace
}  // namespace infuse::daemon
