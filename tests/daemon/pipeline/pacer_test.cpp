#include "daemon/pipeline/pacer.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

namespace infuse::daemon {
namespace {

using namespace std::chrono_literals;

constexpr int kEvents = 1000, kEventsOfASweep = 10, kAlert = 500;

/// A reader of events 0.01 s apart, every tenth of which completes a sweep and one raises an alert.
class PacedReader {
 public:
  explicit PacedReader(Pacer& pacer)
      : pacer_(pacer), thread_([this](std::stop_token s) { run(s); }) {}

  static Stamp stamp(int event) { return Stamp::from_ns(1'000'000'000'000 + 10'000'000L * event); }

  /// Number of events that were passed on once they have been for 150 ms.
  int settled() const {
    for (int last = -1; last != passed_;) {
      last = passed_;
      std::this_thread::sleep_for(150ms);
    }
    return passed_;
  }

 private:
  void run(std::stop_token stop) {
    for (int k = 0; k < kEvents; ++k) {
      pacer_.wait_until(stamp(k), stop);
      if (stop.stop_requested()) return;
      ++passed_;
      if (k % kEventsOfASweep == kEventsOfASweep - 1) pacer_.reach_sweep();
      if (k == kAlert) pacer_.reach_alert();
    }
  }

  Pacer& pacer_;
  std::atomic<int> passed_ = 0;
  std::jthread thread_;
};

TEST(Pacer, AStepPassesOnOneSweep) {
  Pacer pacer(0);
  PacedReader reader(pacer);
  EXPECT_EQ(reader.settled(), 0);
  for (int sweep = 1; sweep <= 3; ++sweep) {
    pacer.step();
    EXPECT_EQ(reader.settled(), sweep * kEventsOfASweep);
  }
}

TEST(Pacer, NothingPassesBeforeItBegins) {
  Pacer pacer(std::nullopt);
  pacer.hold();
  PacedReader reader(pacer);
  EXPECT_EQ(reader.settled(), 0);
  pacer.begin();
  EXPECT_EQ(reader.settled(), kEvents);
}

TEST(Pacer, ASeekStopsBeforeItsStampAndStaysPaused) {
  Pacer pacer(0);
  PacedReader reader(pacer);
  pacer.seek(PacedReader::stamp(123));
  EXPECT_EQ(reader.settled(), 123);
  pacer.seek(PacedReader::stamp(50));  // has passed
  EXPECT_EQ(reader.settled(), 123);
  pacer.step();
  EXPECT_EQ(reader.settled(), 130);
}

TEST(Pacer, AnAlertEndsOnlyASeekOfAlerts) {
  Pacer pacer(0);
  PacedReader reader(pacer);
  pacer.reach_alert();
  EXPECT_EQ(reader.settled(), 0);
  pacer.seek(PacedReader::stamp(200));
  pacer.reach_alert();
  EXPECT_EQ(reader.settled(), 200);
  pacer.seek_alert();
  EXPECT_EQ(reader.settled(), kAlert + 1);
  pacer.seek(PacedReader::stamp(2 * kEvents));
  EXPECT_EQ(reader.settled(), kEvents);
}

TEST(Pacer, AfterASeekTheRateIsThatOfBefore) {
  Pacer pacer(1);
  const auto begin = HostClock::now();
  PacedReader reader(pacer);
  pacer.seek(PacedReader::stamp(kEvents - 50));  // then 0.5 s
  while (reader.settled() < kEvents) {
  }
  const auto taken = HostClock::now() - begin;
  EXPECT_GT(taken, 400ms);
  EXPECT_LT(taken, 5s);  // without the seek, 10 s
}

}  // namespace
}  // namespace infuse::daemon
