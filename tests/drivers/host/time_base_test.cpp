#include "drivers/host/time_base.hpp"

#include <gtest/gtest.h>

namespace infuse::host {
namespace {

constexpr int64_t kSecond = 1'000'000'000;
constexpr ClockReading kStartReading{100 * kSecond, 1'700'000'000 * kSecond};

/// The clocks `seconds` after the start, the wall clock set forward by `step_ns` since.
ClockReading clocks_after_start(double seconds, int64_t step_ns = 0) {
  const int64_t ns = from_seconds(seconds).count();
  return {kStartReading.monotonic_ns + ns, kStartReading.wall_ns + ns + step_ns};
}

Stamp stamp_after_start(double seconds) {
  return Stamp::from_ns(kStartReading.wall_ns) + from_seconds(seconds);
}

TEST(TimeBase, IsWallTimeAtTheStartAndMonotonicAfterIt) {
  const TimeBase base(kStartReading);
  EXPECT_EQ(base.at_monotonic(kStartReading.monotonic_ns), stamp_after_start(0));
  EXPECT_EQ(base.at_monotonic(clocks_after_start(5, -3600 * kSecond).monotonic_ns),
            stamp_after_start(5));
}

TEST(TimeBase, NowAdvancesAndIsNearTheWallClock) {
  const TimeBase base;
  const Stamp first = base.now();
  const Stamp second = base.now();
  EXPECT_LE(first, second);
  EXPECT_LT(distance_between(first, Stamp::from_ns(ClockReading::now().wall_ns)),
            Duration(kSecond));
}

TEST(WallStamps, StampsAMessageByItsAge) {
  const TimeBase base(kStartReading);
  WallStamps stamps(base);
  stamps.update(clocks_after_start(1));
  EXPECT_EQ(stamps.stamp_of(clocks_after_start(0.75).wall_ns), stamp_after_start(0.75));
  EXPECT_EQ(stamps.last_update(), stamp_after_start(1));
}

TEST(WallStamps, AStepOfTheWallClockNeverReordersMessages) {
  for (const int64_t step : {3600 * kSecond, -3600 * kSecond, kSecond / 100, -kSecond / 100}) {
    const TimeBase base(kStartReading);
    WallStamps stamps(base);
    stamps.update(clocks_after_start(1));
    const Stamp before = stamps.stamp_of(clocks_after_start(0.999).wall_ns);
    // The batch contains a message of before the step and one of after it.
    stamps.update(clocks_after_start(2, step));
    EXPECT_EQ(stamps.steps(), 1U);
    const Stamp around = stamps.stamp_of(clocks_after_start(1.5).wall_ns);
    EXPECT_EQ(stamps.stamp_of(clocks_after_start(1.9, step).wall_ns), around);
    stamps.update(clocks_after_start(3, step));
    EXPECT_EQ(stamps.steps(), 1U);
    const Stamp after = stamps.stamp_of(clocks_after_start(2.5, step).wall_ns);
    EXPECT_EQ(after, stamp_after_start(2.5));
    EXPECT_LT(before, around);
    EXPECT_LT(around, after);
  }
}

TEST(WallStamps, DoesNotCountASlewedClockAsAStep) {
  const TimeBase base(kStartReading);
  WallStamps stamps(base);
  stamps.update(clocks_after_start(0));
  // 500 ppm, the maximum rate at which the kernel slews.
  stamps.update(clocks_after_start(10, 5'000'000));
  EXPECT_EQ(stamps.steps(), 0U);
}

TEST(WallStamps, RejectsAnImpossibleAge) {
  const TimeBase base(kStartReading);
  WallStamps stamps(base);
  stamps.update(clocks_after_start(1));
  EXPECT_EQ(stamps.stamp_of(clocks_after_start(2).wall_ns), stamp_after_start(1));
  EXPECT_EQ(stamps.stamp_of(0), stamp_after_start(1));
}

}  // namespace
}  // namespace infuse::host
