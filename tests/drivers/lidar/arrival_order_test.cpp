#include "drivers/lidar/arrival_order.hpp"

#include <gtest/gtest.h>

namespace infuse::lidar {
namespace {

using std::chrono::microseconds;

Stamp at_ms(int64_t ms) { return Stamp::from_ns(ms * 1'000'000); }

TEST(ArrivalOrder, ClassifiesLateDuplicateAndResetCounters) {
  ArrivalOrder order(std::chrono::hours(1));
  EXPECT_EQ(order.add(microseconds(1'000), at_ms(0)).arrival, Arrival::kFirst);
  EXPECT_EQ(order.add(microseconds(2'000), at_ms(1)).arrival, Arrival::kNext);
  EXPECT_EQ(order.add(microseconds(2'000), at_ms(1)).arrival, Arrival::kDuplicate);
  EXPECT_EQ(order.add(microseconds(4'000), at_ms(3)).arrival, Arrival::kNext);
  const auto late = order.add(microseconds(3'000), at_ms(3));
  EXPECT_EQ(late.arrival, Arrival::kLate);
  EXPECT_EQ(late.delay, microseconds(-1'000));
  EXPECT_EQ(order.add(microseconds(1'500), at_ms(3)).arrival, Arrival::kTooLate);
  EXPECT_EQ(order.add(microseconds(1'000), at_ms(3)).arrival, Arrival::kDuplicate);
  EXPECT_EQ(order.add(microseconds(5'000), at_ms(4)).arrival, Arrival::kNext);
  // A restart: the counter begins again. GPS lock: it jumps ahead of the host's clock.
  EXPECT_EQ(order.add(microseconds(3'000'000'000), at_ms(5)).arrival, Arrival::kClockJump);
  EXPECT_EQ(order.add(microseconds(3'000'001'000), at_ms(6)).arrival, Arrival::kNext);
  EXPECT_EQ(order.add(microseconds(100), at_ms(7)).arrival, Arrival::kClockJump);
  EXPECT_EQ(order.add(microseconds(1'100), at_ms(8)).arrival, Arrival::kNext);
}

TEST(ArrivalOrder, DoesNotCountALongSilenceAsAJump) {
  ArrivalOrder order(std::chrono::hours(1));
  order.add(microseconds(1'000), at_ms(0));
  EXPECT_EQ(order.add(microseconds(60'001'000), at_ms(60'010)).arrival, Arrival::kNext);
  EXPECT_EQ(order.add(microseconds(60'002'000), at_ms(120'000)).arrival, Arrival::kClockJump);
}

TEST(ArrivalOrder, DoesNotCountTheTopOfTheHourAsAJump) {
  ArrivalOrder order(std::chrono::hours(1));
  order.add(microseconds(3'599'999'900), at_ms(0));
  const auto verdict = order.add(microseconds(453), at_ms(1));
  EXPECT_EQ(verdict.arrival, Arrival::kNext);
  EXPECT_EQ(verdict.delay, microseconds(553));
}

TEST(ArrivalOrder, ACounterThatNeverWrapsMayPassTheHour) {
  ArrivalOrder order(Duration(0));
  const Duration start(1'700'000'000'000'000'000);
  order.add(start, at_ms(0));
  EXPECT_EQ(order.add(start + std::chrono::hours(2), at_ms(7'200'010)).arrival, Arrival::kNext);
  EXPECT_EQ(order.add(start, at_ms(7'200'020)).arrival, Arrival::kDuplicate);
  EXPECT_EQ(order.add(Duration(5), at_ms(7'200'030)).arrival, Arrival::kClockJump);
}

}  // namespace
}  // namespace infuse::lidar
