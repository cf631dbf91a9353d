#include "daemon/pipeline/drive_ticker.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace infuse::daemon {
namespace {

Stamp tick_at(double seconds) {
  return Stamp::from_ns(1'700'000'000'500'000'000) + from_seconds(seconds);
}

class DriveTickerTest : public testing::Test {
 protected:
  std::vector<Stamp> ticks(Stamp stamp) {
    std::vector<Stamp> ticks;
    ticker_.advance(stamp, [&](Stamp tick) { ticks.push_back(tick); });
    return ticks;
  }
  DriveTicker ticker_;
};

TEST_F(DriveTickerTest, TicksEverySecondSinceTheFirstStamp) {
  EXPECT_TRUE(ticks(tick_at(0)).empty());
  EXPECT_TRUE(ticks(tick_at(0.999)).empty());
  EXPECT_EQ(ticks(tick_at(1)), std::vector{tick_at(1)});
  EXPECT_TRUE(ticks(tick_at(1.5)).empty());
  EXPECT_EQ(ticks(tick_at(4.2)), (std::vector{tick_at(2), tick_at(3), tick_at(4)}));
}

TEST_F(DriveTickerTest, DisorderIsNotAStepBack) {
  ticks(tick_at(0));
  EXPECT_EQ(ticks(tick_at(1)), std::vector{tick_at(1)});
  EXPECT_TRUE(ticks(tick_at(0.5)).empty());
  EXPECT_EQ(ticks(tick_at(2)), std::vector{tick_at(2)});
}

TEST_F(DriveTickerTest, AStepBackBeginsAnew) {
  ticks(tick_at(100));
  EXPECT_TRUE(ticks(tick_at(0)).empty());
  EXPECT_EQ(ticks(tick_at(1)), std::vector{tick_at(1)});
}

TEST_F(DriveTickerTest, AJumpByAYearGivesFewTicks) {
  ticks(tick_at(0));
  const auto all = ticks(tick_at(365.0 * 86'400));
  EXPECT_EQ(all.size(), static_cast<size_t>(DriveTicker::kMaxTicks) + 1);
  EXPECT_EQ(all.back(), tick_at(365.0 * 86'400));
  EXPECT_EQ(ticks(tick_at(365.0 * 86'400 + 1)).size(), 1U);
}

TEST_F(DriveTickerTest, TicksEndAtTheEndOfTime) {
  ticks(tick_at(0));
  EXPECT_LE(ticks(Stamp::latest()).size(), 31U);
  EXPECT_LE(ticks(Stamp::latest()).size(), 31U);
  EXPECT_LE(ticks(Stamp::earliest()).size(), 31U);
}

}  // namespace
}  // namespace infuse::daemon
