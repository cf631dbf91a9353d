#include "daemon/service/map_watch.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <new>
#include <thread>

#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

/// A map whose text is its digest; "damaged" cannot be used, nor can "huge".
class MapWatchTest : public testing::Test {
 protected:
  MapWatchTest()
      : watch_(
            "map", map_in(folder_), "one",
            [this](const std::string& in_use, const std::stop_token&) { return replace(in_use); }) {
  }

  static std::filesystem::path map_in(const ScratchFolder& folder) {
    folder.write("m", "one");
    return folder / "m";
  }

  Result<std::string> replace(const std::string& in_use) {
    ++looks_;
    EXPECT_EQ(in_use, watch_.in_use().digest);
    std::string text = folder_.read("m");
    if (text == "damaged" || text.empty()) return fail("is damaged", "m");
    if (text == "huge") throw std::bad_alloc();
    return text;
  }

  /// Seconds of the watch, each with the result of the one before.
  void run(int seconds) {
    for (int k = 0; k < seconds; ++k) {
      now_ += std::chrono::seconds(1);
      watch_.poll(now_);
      while (watch_.looks()) std::this_thread::sleep_for(std::chrono::microseconds(100));
    }
  }

  const ScratchFolder folder_;
  std::atomic<int> looks_ = 0;
  MapWatch::Clock::time_point now_;
  MapWatch watch_;
};

TEST_F(MapWatchTest, WhatDoesNotChangeIsReadOnce) {
  run(5);
  EXPECT_EQ(looks_, 1);
  EXPECT_EQ(watch_.in_use().digest, "one");
}

TEST_F(MapWatchTest, AnotherMapIsTakenOverOnce) {
  folder_.write("m", "second");
  run(5);
  EXPECT_EQ(looks_, 1);
  EXPECT_EQ(watch_.in_use().digest, "second");
  EXPECT_EQ(watch_.in_use().problem, "");
}

TEST_F(MapWatchTest, ADamagedMapIsRefusedAndTriedAgainEverMoreRarely) {
  folder_.write("m", "damaged");
  run(60);
  EXPECT_EQ(watch_.in_use().digest, "one");
  EXPECT_EQ(watch_.in_use().problem, "m: is damaged");
  // At the change, and 5, 10 and 20 s after that, with a second to see each result.
  EXPECT_GE(looks_, 4);
  EXPECT_LE(looks_, 5);
  const int looks = looks_;
  watch_.try_again();
  run(2);
  EXPECT_EQ(looks_, looks + 1);
  folder_.write("m", "three");
  run(4);
  EXPECT_EQ(watch_.in_use().digest, "three");
  EXPECT_EQ(watch_.in_use().problem, "");
}

TEST_F(MapWatchTest, ALookThatSucceedsIsNotRepeatedAtOnce) {
  folder_.write("m", "damaged");
  run(4);
  folder_.write("m", "second");
  for (int k = 0; k < 2; ++k)
    watch_.poll(now_ += std::chrono::seconds(1));  // it is being looked at
  watch_.try_again();
  run(5);
  EXPECT_EQ(watch_.in_use().digest, "second");
  EXPECT_EQ(looks_, 2);
}

TEST_F(MapWatchTest, AMapForWhichMemoryIsMissingIsRefused) {
  folder_.write("m", "huge");
  run(4);
  EXPECT_EQ(watch_.in_use().digest, "one");
  EXPECT_NE(watch_.in_use().problem.find("cannot be put in use"), std::string::npos);
}

TEST_F(MapWatchTest, AMapThatIsGoneStaysInUse) {
  std::filesystem::remove(folder_ / "m");
  run(4);
  EXPECT_EQ(watch_.in_use().digest, "one");
  EXPECT_NE(watch_.in_use().problem, "");
}

}  // namespace
}  // namespace infuse::daemon
