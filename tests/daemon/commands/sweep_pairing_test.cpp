#include "daemon/commands/sweep_pairing.hpp"

#include <gtest/gtest.h>

namespace infuse::daemon {
namespace {

Stamp at_ms(int64_t ms) { return Stamp::from_ns(ms * 1'000'000); }

/// A sweep of 100 ms without returns.
Sweep sweep_at(int64_t ms, uint64_t sequence) {
  Sweep sweep;
  sweep.stamp = at_ms(ms);
  sweep.span = from_seconds(0.1);
  sweep.sequence = sequence;
  return sweep;
}

TEST(SweepPairing, FindsTheSweepNearestToEachExposure) {
  SweepPairing pairing(Eigen::Isometry3d::Identity(), false);
  for (const int64_t ms : {90, 260, 5000}) pairing.add_exposure(at_ms(ms));
  for (int64_t i = 0; i < 5; ++i) {
    pairing.add_sweep(sweep_at(100 * i, static_cast<uint64_t>(i)));  // middles 50, 150, 250, ...
    pairing.advance(at_ms(100 * i + 100));
  }
  EXPECT_FALSE(pairing.done());
  const auto pairs = pairing.finish();
  ASSERT_EQ(pairs.size(), 3U);
  EXPECT_TRUE(pairs[0].found);
  EXPECT_EQ(pairs[0].sweep.sequence, 0U);
  EXPECT_EQ(pairs[0].gap, from_seconds(0.04));
  EXPECT_EQ(pairs[1].sweep.sequence, 2U);
  EXPECT_EQ(pairs[1].gap, from_seconds(0.01));
  EXPECT_FALSE(pairs[2].found);
}

TEST(SweepPairing, WithoutOdometryNothingIsDeskewed) {
  SweepPairing pairing(Eigen::Isometry3d::Identity(), false);
  pairing.add_exposure(at_ms(50));
  pairing.add_sweep(sweep_at(0, 0));
  pairing.advance(at_ms(2000));
  EXPECT_TRUE(pairing.done());
  const auto pairs = pairing.finish();
  EXPECT_EQ(pairs[0].deskew_reason, "the drive has no odometry");
  EXPECT_FALSE(pairs[0].twist.has_value());
}

}  // namespace
}  // namespace infuse::daemon
