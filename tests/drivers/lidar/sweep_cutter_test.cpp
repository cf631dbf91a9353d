#include "drivers/lidar/sweep_cutter.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace infuse::lidar {
namespace {

TEST(SweepCutter, CutsAtTheCutAzimuth) {
  SweepCutter cutter(9'000);
  EXPECT_TRUE(cutter.process_sequence(8'980, 0, false));  // the first sequence
  EXPECT_FALSE(cutter.process_sequence(8'999, 19, false));
  EXPECT_TRUE(cutter.process_sequence(9'000, 1, false));
  EXPECT_FALSE(cutter.process_sequence(9'020, 20, false));
  for (int turned = 40; turned < 36'000; turned += 20) {
    EXPECT_FALSE(cutter.process_sequence((9'000 + turned) % 36'000, 20, false)) << turned;
  }
  EXPECT_TRUE(cutter.process_sequence(9'000, 20, false));
}

TEST(SweepCutter, JitterAtTheCutCutsOnce) {
  SweepCutter cutter(0);
  cutter.process_sequence(35'990, 0, false);
  EXPECT_TRUE(cutter.process_sequence(5, 15, false));
  EXPECT_FALSE(cutter.process_sequence(35'998, -7, false));
  EXPECT_FALSE(cutter.process_sequence(10, 12, false));
}

TEST(SweepCutter, LossOfMoreThanATurnCutsOnce) {
  SweepCutter cutter(0);
  cutter.process_sequence(100, 0, false);
  EXPECT_TRUE(cutter.process_sequence(200, 36'100, false));
  EXPECT_FALSE(cutter.process_sequence(220, 20, false));
  EXPECT_FALSE(cutter.process_sequence(35'990, 35'770, false));
  EXPECT_TRUE(cutter.process_sequence(10, 20, false));
}

TEST(SweepCutter, APartialTurnEndsAtItsJumpAndAFullTurnIsCutAgain) {
  SweepCutter cutter(0);
  cutter.process_sequence(27'000, 0, false);
  EXPECT_TRUE(cutter.process_sequence(10, 9'010, false));  // the jump is not known yet
  EXPECT_FALSE(cutter.process_sequence(9'000, 8'990, false));
  EXPECT_TRUE(cutter.process_sequence(27'000, 18'000, true));
  EXPECT_TRUE(cutter.partial_turn());
  EXPECT_FALSE(cutter.process_sequence(10, 9'010, false));
  EXPECT_TRUE(cutter.is_known_jump(9'050, 26'950));
  EXPECT_FALSE(cutter.is_known_jump(9'050, 28'000));
  EXPECT_FALSE(cutter.process_sequence(9'000, 8'990, false));
  EXPECT_FALSE(
      cutter.process_sequence(26'990, 17'990, false));  // the sensor scans the full turn now
  EXPECT_TRUE(cutter.process_sequence(10, 9'020, false));
  EXPECT_FALSE(cutter.partial_turn());
}

}  // namespace
}  // namespace infuse::lidar
