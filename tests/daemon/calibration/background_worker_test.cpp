#include "daemon/calibration/background_worker.hpp"
#include "tests/stamp_at.hpp"

#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>

#include <atomic>
#include <thread>

namespace infuse::daemon {
namespace {

constexpr Duration kTenSeconds{10'000'000'000};

TEST(Background, AResultIsVisibleAtItsStatedTimeWhateverItsDuration) {
  for (const int milliseconds : {0, 200}) {
    BackgroundWorker background(true);
    std::atomic<int> result = 0;
    EXPECT_FALSE(background.busy());
    background.start(at(100), kTenSeconds, [&](const std::stop_token&) {
      std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
      result = 7;
    });
    EXPECT_TRUE(background.busy());
    EXPECT_FALSE(background.consume_result(at(100)));
    EXPECT_FALSE(background.consume_result(at(109)));
    EXPECT_TRUE(background.consume_result(at(110)));  // waits
    EXPECT_EQ(result, 7);
    EXPECT_FALSE(background.busy());
    EXPECT_FALSE(background.consume_result(at(120)));
  }
}

TEST(Background, LiveDoesNotBlock) {
  BackgroundWorker background(false);
  std::atomic<bool> go = false;
  background.start(at(0), kTenSeconds, [&](const std::stop_token&) {
    while (!go) std::this_thread::yield();
  });
  EXPECT_FALSE(background.consume_result(at(60)));
  EXPECT_TRUE(background.busy());
  go = true;
  while (!background.consume_result(at(61))) std::this_thread::yield();
  EXPECT_FALSE(background.busy());
}

TEST(Background, RunsOneWorkAfterTheOther) {
  BackgroundWorker background(true);
  int sum = 0;
  for (int i = 1; i <= 50; ++i) {
    background.start(at(i), Duration::zero(), [&sum, i](const std::stop_token&) { sum += i; });
    EXPECT_TRUE(background.consume_result(at(i)));
  }
  EXPECT_EQ(sum, 50 * 51 / 2);
}

/// Runs until a stop is requested.
void endless(const std::stop_token& stop) {
  while (!stop.stop_requested()) std::this_thread::yield();
}

TEST(Background, CancelledWorkEndsAndIsNeverVisible) {
  BackgroundWorker replay(true);
  replay.start(at(0), kTenSeconds, endless);
  replay.cancel();  // waits
  EXPECT_FALSE(replay.busy());
  EXPECT_FALSE(replay.consume_result(at(60)));
  int done = 0;
  replay.start(at(61), Duration::zero(), [&](const std::stop_token& stop) {
    EXPECT_FALSE(stop.stop_requested());
    ++done;
  });
  EXPECT_TRUE(replay.consume_result(at(61)));
  EXPECT_EQ(done, 1);

  BackgroundWorker live(false);
  live.start(at(0), kTenSeconds, endless);
  live.cancel();
  while (live.busy()) std::this_thread::yield();
  EXPECT_FALSE(live.consume_result(at(60)));
}

TEST(Background, ShutDownFromAnotherThreadUnblocks) {
  BackgroundWorker background(true);
  background.start(at(0), Duration::zero(), endless);
  std::jthread other([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    background.shut_down();
  });
  EXPECT_FALSE(background.consume_result(at(1)));  // would block forever
  bool began = false;
  background.start(at(2), Duration::zero(), [&](const std::stop_token&) { began = true; });
  EXPECT_FALSE(background.consume_result(at(3)));
  EXPECT_FALSE(began);
}

TEST(Background, WorkThatIsToEndHasItsShareOfTheProcessorAgain) {
  bool permitted = false;
  std::thread([&] {
    const sched_param none{};
    permitted = ::pthread_setschedparam(::pthread_self(), SCHED_IDLE, &none) == 0 &&
                ::pthread_setschedparam(::pthread_self(), SCHED_OTHER, &none) == 0;
  }).join();
  if (!permitted) GTEST_SKIP() << "a thread may not leave SCHED_IDLE here (RLIMIT_NICE)";
  std::atomic<int> during = -1;
  bool ordinary = false;
  {
    BackgroundWorker background(false);
    background.start(at(0), kTenSeconds, [&](const std::stop_token& stop) {
      during = ::sched_getscheduler(0);
      endless(stop);
      for (int k = 0; k < 1000 && !ordinary; ++k) {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
        ordinary = ::sched_getscheduler(0) == SCHED_OTHER;
      }
    });
    while (during < 0) std::this_thread::yield();
  }
  EXPECT_EQ(during, SCHED_IDLE);
  EXPECT_TRUE(ordinary);
}

TEST(Background, DestructionStopsTheRunningWork) {
  bool ended = false;
  {
    BackgroundWorker background(true);
    std::atomic<bool> began = false;
    background.start(at(0), kTenSeconds, [&](const std::stop_token& stop) {
      began = true;
      endless(stop);
      ended = true;
    });
    while (!began) std::this_thread::yield();
  }
  EXPECT_TRUE(ended);
}

}  // namespace
}  // namespace infuse::daemon
