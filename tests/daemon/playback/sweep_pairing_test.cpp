#include "daemon/playback/sweep_pairing.hpp"

#include <gtest/gtest.h>

namespace infuse::daemon {
namespace {

Stamp at_ms(int64_t ms) { return Stamp::from_ns(ms * 1'000'000); }

/// A sweep of 100 ms with one return.
Sweep sweep_at(int64_t ms, uint64_t sequence) {
  Sweep sweep;
  sweep.stamp = at_ms(ms);
  sweep.span = from_seconds(0.1);
  sweep.sequence = sequence;
  sweep.resize(1);
  sweep.x[0] = 7;
  sweep.y[0] = sweep.z[0] = 0;
  sweep.time_offset_ns[0] = 50'000'000;
  return sweep;
}

TEST(SweepPairing, FindsTheSweepNearestToEachExposure) {
  SweepPairing pairing({}, Eigen::Isometry3d::Identity(), false);
  for (const int64_t ms : {90, 200, 540, 5000}) pairing.add_exposure(at_ms(ms));
  for (int64_t i = 0; i < 5; ++i) {
    pairing.add_sweep(sweep_at(100 * i, static_cast<uint64_t>(i)));
    pairing.advance(at_ms(100 * i + 100));
  }
  EXPECT_FALSE(pairing.done());
  const auto pairs = pairing.finish();
  ASSERT_EQ(pairs.size(), 4U);
  EXPECT_TRUE(pairs[0].found);
  EXPECT_EQ(pairs[0].sweep.sequence, 0U);
  EXPECT_EQ(pairs[0].gap, Duration::zero());
  EXPECT_EQ(pairs[1].sweep.sequence, 2U) << "the end of a sweep belongs to the next";
  EXPECT_EQ(pairs[1].gap, Duration::zero());
  EXPECT_EQ(pairs[2].sweep.sequence, 4U);
  EXPECT_EQ(pairs[2].gap, from_seconds(0.04));
  EXPECT_FALSE(pairs[3].found);
}

TEST(SweepPairing, LeavesOutSweepsFartherThanTheMaximumGap) {
  for (const bool wide : {false, true}) {
    SweepPairing pairing({}, Eigen::Isometry3d::Identity(), false, from_seconds(wide ? 0.2 : 0.1));
    pairing.add_exposure(at_ms(250));
    pairing.add_sweep(sweep_at(0, 0));  // ends at 100 ms
    const auto pairs = pairing.finish();
    EXPECT_EQ(pairs[0].found, wide);
  }
}

TEST(SweepPairing, SettledSweepsCanBeTaken) {
  SweepPairing pairing({}, Eigen::Isometry3d::Identity(), false);
  for (const int64_t ms : {50, 4950}) pairing.add_exposure(at_ms(ms));
  pairing.add_sweep(sweep_at(0, 3));
  pairing.advance(at_ms(100));
  EXPECT_EQ(pairing.settled(), 0U);
  pairing.advance(at_ms(2000));
  ASSERT_EQ(pairing.settled(), 1U);
  EXPECT_EQ(pairing.take(0).sweep.sequence, 3U);
  pairing.add_sweep(sweep_at(4900, 9));
  const auto rest = pairing.finish();
  ASSERT_EQ(rest.size(), 2U);
  EXPECT_FALSE(rest[0].found);
  EXPECT_EQ(rest[0].sweep.size(), 0U);
  EXPECT_EQ(rest[1].sweep.sequence, 9U);
}

TEST(SweepPairing, ASweepDeskewedToTheExposureIsUsedAsItIs) {
  SweepPairing pairing({}, Eigen::Isometry3d::Identity(), false);
  for (const int64_t ms : {50, 60}) pairing.add_exposure(at_ms(ms));
  Sweep sweep = sweep_at(0, 0);
  sweep.deskewed = true;
  pairing.add_sweep(sweep);
  const auto pairs = pairing.finish();
  EXPECT_EQ(pairs[0].deskew_reason, "");
  EXPECT_EQ(pairs[0].sweep.x[0], 7);
  EXPECT_EQ(pairs[1].deskew_reason, "the drive has no odometry");
}

TEST(SweepPairing, WithoutOdometryNothingIsDeskewed) {
  SweepPairing pairing({}, Eigen::Isometry3d::Identity(), false);
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
