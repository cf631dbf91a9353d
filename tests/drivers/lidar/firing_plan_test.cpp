#include "drivers/lidar/firing_plan.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace infuse::lidar {
namespace {

constexpr SequenceTiming kTiming{50'000, 60};

using Azimuths = std::vector<uint16_t>;

FiringPlan plan_of(const Azimuths& azimuths, const std::optional<FollowingPacket>& following,
                   int previous_step, double rate = 0) {
  FiringPlan plan;
  plan_firings(azimuths, following, previous_step, rate, kTiming, plan);
  return plan;
}

std::vector<int> steps(const FiringPlan& plan) {
  std::vector<int> all;
  for (size_t i = 0; i < plan.count; ++i) all.push_back(plan.sequences[i].step);
  return all;
}

std::vector<int64_t> times_us(const FiringPlan& plan) {
  std::vector<int64_t> all;
  for (size_t i = 0; i < plan.count; ++i) all.push_back(plan.sequences[i].time_ns / 1000);
  return all;
}

TEST(FiringPlan, AzimuthGrowsToTheNextSequenceAlsoInTheNextPacket) {
  const Azimuths packet{35'970, 35'990, 11, 30};
  const auto plan = plan_of(packet, FollowingPacket{52, 200'000}, 7);
  EXPECT_EQ(steps(plan), (std::vector<int>{20, 21, 19, 22}));
  EXPECT_EQ(times_us(plan), (std::vector<int64_t>{0, 50, 100, 150}));
  EXPECT_EQ(plan.sequences[2].advance, 21);
  // No following packet, or not directly: the last step is used again.
  EXPECT_EQ(steps(plan_of(packet, std::nullopt, 7)), (std::vector<int>{20, 21, 19, 19}));
  EXPECT_EQ(steps(plan_of(packet, FollowingPacket{52, 400'000}, 7)),
            (std::vector<int>{20, 21, 19, 19}));
}

TEST(FiringPlan, ASingleSequenceUsesTheStepOfThePreviousPacket) {
  const Azimuths packet{100};
  EXPECT_EQ(steps(plan_of(packet, std::nullopt, 20)), std::vector<int>{20});
  EXPECT_EQ(steps(plan_of(packet, FollowingPacket{119, 50'000}, 20)), std::vector<int>{19});
}

TEST(FiringPlan, AJumpIsNotInterpolatedAndLaterSequencesAreRetimed) {
  const Azimuths packet{8'960, 8'980, 27'010, 27'030};
  // 18 010 hundredths at 20 per sequence are 45 ms; the next packet contains the exact time.
  const auto plan = plan_of(packet, FollowingPacket{27'050, 45'183'000}, 20);
  EXPECT_EQ(steps(plan), (std::vector<int>{20, 20, 20, 20}));
  EXPECT_FALSE(plan.sequences[1].after_jump);
  EXPECT_TRUE(plan.sequences[2].after_jump);
  EXPECT_EQ(times_us(plan), (std::vector<int64_t>{0, 50, 45'083, 45'133}));
  const auto alone = plan_of(packet, std::nullopt, 20);
  EXPECT_EQ(times_us(alone), (std::vector<int64_t>{0, 50, 45'125, 45'175}));
}

/// 20 hundredths in 50 µs. Three packets of four sequences are missing after the one with the jump;
/// then also a whole turn.
TEST(FiringPlan, PacketsMissingAfterAJumpDoNotMoveTheSequencesBehindIt) {
  const Azimuths packet{8'960, 8'980, 27'010, 27'030};
  const std::vector<int64_t> times{0, 50, 45'083, 45'133};
  const double rate = 20.0 / 50'000;
  EXPECT_EQ(times_us(plan_of(packet, FollowingPacket{27'050, 45'183'000}, 20, rate)), times);
  const FollowingPacket after_loss{27'290, 45'783'000};
  EXPECT_EQ(times_us(plan_of(packet, after_loss, 20, rate)), times);
  const FollowingPacket after_turn{27'290, 45'783'000 + 90'000'000};
  EXPECT_EQ(times_us(plan_of(packet, after_turn, 20, rate)), times);
}

TEST(FiringPlan, JitterBackwardsIsNotATurn) {
  const auto plan = plan_of(Azimuths{100, 99, 101}, FollowingPacket{100, 150'000}, 0);
  EXPECT_EQ(steps(plan), (std::vector<int>{0, 2, 0}));
  EXPECT_FALSE(plan.sequences[1].after_jump);
  EXPECT_EQ(plan.sequences[1].advance, -1);
}

TEST(FiringPlan, AdvanceIsForwardExceptForJitter) {
  EXPECT_EQ(azimuth_advance(35'990, 10), 20);
  EXPECT_EQ(azimuth_advance(10, 35'990), -20);
  EXPECT_EQ(azimuth_advance(0, 35'899), 35'899);
  EXPECT_EQ(azimuth_advance(0, 18'000), 18'000);
}

}  // namespace
}  // namespace infuse::lidar
