#include "fusion/motion/sample_queue.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace infuse::motion {
namespace {

using StampCheck = SampleQueue::StampCheck;

Stamp at(double seconds) { return Stamp::from_ns(static_cast<int64_t>(seconds * 1e9)); }

std::vector<Stamp> drained(SampleQueue& queue, Stamp until) {
  std::vector<Stamp> out;
  queue.drain(until, [&](const SampleQueue::Entry& entry) { out.push_back(entry.stamp); });
  return out;
}

TEST(SampleQueue, ReturnsSamplesInOrderOfTime) {
  std::vector<Stamp> stamps;
  for (int i = 0; i < 100; ++i) stamps.push_back(at(0.125 * i));
  std::vector<Stamp> shuffled = stamps;
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(1));
  SampleQueue queue;
  for (const Stamp stamp : shuffled) queue.insert(stamp, WheelOdometry{});
  EXPECT_EQ(queue.newest(), stamps.back());
  EXPECT_EQ(drained(queue, at(5)), std::vector(stamps.begin(), stamps.begin() + 41));
  EXPECT_EQ(queue.oldest(), at(5.125));
  EXPECT_EQ(drained(queue, Stamp::latest()), std::vector(stamps.begin() + 41, stamps.end()));
}

TEST(SampleQueue, SamplesOfOneTimeKeepTheOrderOfTheirArrival) {
  SampleQueue queue;
  queue.insert(at(1), WheelOdometry{});
  queue.insert(at(1), ImuSample{});
  queue.insert(at(1), PoseMark{});
  std::vector<size_t> kinds;
  queue.drain(at(1), [&](const auto& entry) { kinds.push_back(entry.sample.index()); });
  EXPECT_EQ(kinds, (std::vector<size_t>{0, 1, 4}));
}

TEST(SampleQueue, AMarkAheadDoesNotMoveTheNewestStamp) {
  SampleQueue queue;
  queue.insert(at(1), WheelOdometry{});
  queue.insert(at(9), PoseMark{});
  EXPECT_EQ(queue.newest(), at(1));
}

TEST(SampleQueue, OneStampFarAwayIsAnErrorAndTwoAreAStep) {
  SampleQueue queue;
  EXPECT_EQ(queue.check(at(100), Stamp::earliest()), StampCheck::kInOrder);
  queue.insert(at(100), WheelOdometry{});
  EXPECT_EQ(queue.check(at(99.5), at(99.9)), StampCheck::kLate);
  EXPECT_EQ(queue.check(at(200), at(99.9)), StampCheck::kIsolated);
  EXPECT_EQ(queue.check(at(100.1), at(99.9)), StampCheck::kInOrder);  // so the one before was wrong
  EXPECT_EQ(queue.check(at(200), at(99.9)), StampCheck::kIsolated);
  EXPECT_EQ(queue.check(at(200.1), at(99.9)), StampCheck::kInOrder);  // a pause
  EXPECT_EQ(queue.check(at(50), at(99.9)), StampCheck::kIsolated);
  EXPECT_EQ(queue.check(at(50.1), at(99.9)), StampCheck::kClockStep);
}

TEST(SampleQueue, IsFullAtItsCapacityAndEmptyWhenCleared) {
  SampleQueue queue;
  for (int i = 0; !queue.full(); ++i) {
    ASSERT_LT(i, 10'000);
    queue.insert(at(i), WheelOdometry{});
  }
  queue.clear();
  EXPECT_FALSE(queue.full());
  EXPECT_EQ(queue.newest(), Stamp::earliest());
}

}  // namespace
}  // namespace infuse::motion
