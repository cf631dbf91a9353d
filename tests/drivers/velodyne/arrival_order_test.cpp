#include "drivers/velodyne/arrival_order.hpp"

#include <gtest/gtest.h>

namespace infuse::velodyne {
namespace {

Stamp at_ms(int64_t ms) { return Stamp::from_ns(ms * 1'000'000); }

TEST(ArrivalOrder, ClassifiesLateDuplicateAndResetCounters) {
  ArrivalOrder order;
  EXPECT_EQ(order.add(1'000, at_ms(0)).arrival, Arrival::kFirst);
  EXPECT_EQ(order.add(2'000, at_ms(1)).arrival, Arrival::kNext);
  EXPECT_EQ(order.add(2'000, at_ms(1)).arrival, Arrival::kDuplicate);
  EXPECT_EQ(order.add(4'000, at_ms(3)).arrival, Arrival::kNext);
  const auto late = order.add(3'000, at_ms(3));
  EXPECT_EQ(late.arrival, Arrival::kLate);
  EXPECT_EQ(late.delay_us, -1'000);
  EXPECT_EQ(order.add(1'500, at_ms(3)).arrival, Arrival::kTooLate);
  EXPECT_EQ(order.add(1'000, at_ms(3)).arrival, Arrival::kDuplicate);
  EXPECT_EQ(order.add(5'000, at_ms(4)).arrival, Arrival::kNext);
  // A restart: the counter begins again. GPS lock: it jumps ahead of the host's clock.
  EXPECT_EQ(order.add(3'000'000'000, at_ms(5)).arrival, Arrival::kClockJump);
  EXPECT_EQ(order.add(3'000'001'000, at_ms(6)).arrival, Arrival::kNext);
  EXPECT_EQ(order.add(100, at_ms(7)).arrival, Arrival::kClockJump);
  EXPECT_EQ(order.add(1'100, at_ms(8)).arrival, Arrival::kNext);
}

TEST(ArrivalOrder, DoesNotCountALongSilenceAsAJump) {
  ArrivalOrder order;
  order.add(1'000, at_ms(0));
  EXPECT_EQ(order.add(60'001'000, at_ms(60'010)).arrival, Arrival::kNext);
  EXPECT_EQ(order.add(60'002'000, at_ms(120'000)).arrival, Arrival::kClockJump);
}

TEST(ArrivalOrder, DoesNotCountTheTopOfTheHourAsAJump) {
  ArrivalOrder order;
  order.add(3'599'999'900, at_ms(0));
  const auto verdict = order.add(453, at_ms(1));
  EXPECT_EQ(verdict.arrival, Arrival::kNext);
  EXPECT_EQ(verdict.delay_us, 553);
}

}  // namespace
}  // namespace infuse::velodyne
