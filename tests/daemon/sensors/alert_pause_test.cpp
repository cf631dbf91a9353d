#include "daemon/sensors/alert_pause.hpp"
#include "tests/stamp_at.hpp"

#include <gtest/gtest.h>

namespace infuse::daemon {
namespace {

TEST(AlertPause, AFlappingSensorIsRecordedOncePerPause) {
  AlertPause pause;
  int recorded = 0;
  for (int second = 0; second < 3600; second += 10) {
    if (!pause.is_over("lidar.silent", at(second), from_seconds(600))) continue;
    pause.begin("lidar.silent", at(second));
    ++recorded;
  }
  EXPECT_EQ(recorded, 6);
}

TEST(AlertPause, EachCauseHasItsOwn) {
  AlertPause pause;
  pause.begin("lidar.silent", at(0));
  EXPECT_FALSE(pause.is_over("lidar.silent", at(1), from_seconds(600)));
  EXPECT_TRUE(pause.is_over("lidar.loss", at(1), from_seconds(600)));
  EXPECT_TRUE(pause.is_over("rear.silent", at(1), from_seconds(600)));
  EXPECT_TRUE(pause.is_over("lidar.silent", at(-5), from_seconds(600)));
  EXPECT_TRUE(pause.is_over("lidar.silent", at(1), Duration::zero()));
}

}  // namespace
}  // namespace infuse::daemon
