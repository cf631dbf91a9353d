#include "daemon/health/lidar_health.hpp"
#include "tests/stamp_at.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

/// A lidar with 1808 packets and 10 sweeps per second, checked once per second.
class LidarHealthTest : public testing::Test {
 protected:
  void deliver(uint64_t packets = 1808, uint64_t sweeps = 10) {
    counters_.packets += packets;
    counters_.sweeps += sweeps;
    counters_.returns += sweeps * 60'000;
  }

  const LidarStatus& tick(bool received = true) {
    ++second_;
    if (received) counters_.last_packet = at(second_);
    return health_.update(at(second_), counters_);
  }

  /// Ten seconds without a problem.
  void settle() {
    counters_.clock.trusted = true;
    for (int i = 0; i < 10; ++i) {
      deliver();
      ASSERT_EQ(tick().level, Level::kOk);
    }
  }

  LidarHealth health_{"0.0.0.0:2368", HealthOptions(), at(0)};
  LidarCounters counters_;
  double second_ = 0;
};

TEST_F(LidarHealthTest, RatesAreThoseOfTheLastTenSeconds) {
  settle();
  const LidarStatus& status = tick();  // a second without a packet
  EXPECT_DOUBLE_EQ(status.packets_hz, 1808 * 0.9);
  EXPECT_DOUBLE_EQ(status.sweeps_hz, 9);
  EXPECT_DOUBLE_EQ(status.returns_hz, 540'000);
  EXPECT_TRUE(status.findings.empty());
}

TEST_F(LidarHealthTest, SilenceIsStaleAfterThreeSeconds) {
  settle();
  EXPECT_EQ(tick(false).level, Level::kOk);
  EXPECT_EQ(tick(false).level, Level::kOk);
  const LidarStatus& status = tick(false);
  EXPECT_EQ(status.level, Level::kStale);
  ASSERT_EQ(status.findings.size(), 1U);
  EXPECT_EQ(status.findings[0].what, "no data on 0.0.0.0:2368 for 3.0 s");
  EXPECT_EQ(status.findings[0].since, at(second_));
  ASSERT_EQ(status.transitions.size(), 1U);
  EXPECT_TRUE(status.transitions[0].raised);
  EXPECT_TRUE(tick(false).transitions.empty());

  deliver();
  const LidarStatus& back = tick();
  EXPECT_EQ(back.level, Level::kOk);
  ASSERT_EQ(back.transitions.size(), 1U);
  EXPECT_FALSE(back.transitions[0].raised);
}

TEST_F(LidarHealthTest, MoreSweepsThanALidarCanTurnAreAnError) {
  settle();
  for (int i = 0; i < 12; ++i) {
    deliver(9000, 487);  // a burst of packets with changed azimuths
    tick();
  }
  deliver();
  const LidarStatus& status = tick();
  ASSERT_EQ(status.level, Level::kError);
  EXPECT_STREQ(status.findings[0].id, "too_fast");
  EXPECT_THAT(status.findings[0].what, HasSubstr("no lidar turns so fast"));
}

TEST_F(LidarHealthTest, TwoSendersAreBothNamed) {
  settle();
  counters_.sender = 0x0A00'0007;
  counters_.rival_sender = 0x0A00'0008;
  for (int i = 0; i < 3; ++i) {
    counters_.wrong_sender += 754;
    deliver();
    tick();
  }
  deliver();
  const LidarStatus& status = tick();
  EXPECT_EQ(status.level, Level::kError);
  ASSERT_EQ(status.findings.size(), 1U);
  EXPECT_STREQ(status.findings[0].id, "two_senders");
  EXPECT_THAT(status.findings[0].what, HasSubstr("10.0.0.7 and 10.0.0.8"));
}

// Its datagrams are within the window for ten seconds.
TEST_F(LidarHealthTest, ARivalThatIsGoneIsNotReportedAgain) {
  settle();
  counters_.rival_sender = 0x0A00'0008;
  for (int i = 0; i < 20; ++i) {
    counters_.wrong_sender += 754;
    deliver();
    tick();
  }
  counters_.rival_sender = 0;
  for (int i = 0; i < 20; ++i) {
    deliver();
    for (const Transition& each : tick().transitions) EXPECT_FALSE(each.raised) << each.finding.id;
  }
  EXPECT_EQ(tick().level, Level::kOk);
}

TEST_F(LidarHealthTest, AChangeOfTheSenderIsReportedAtOnce) {
  settle();
  counters_.previous_sender = 0x0A00'0007;
  counters_.sender = 0x0A00'0008;
  counters_.sender_changes = 1;
  counters_.wrong_sender = 20;  // those of the new one, before it was used
  deliver();
  const LidarStatus& status = tick();
  EXPECT_EQ(status.level, Level::kWarn);
  ASSERT_EQ(status.findings.size(), 1U);
  EXPECT_THAT(status.findings[0].what, HasSubstr("from 10.0.0.7 to 10.0.0.8"));
}

TEST_F(LidarHealthTest, SilenceNamesAnUnexpectedSender) {
  counters_.malformed = 12;
  counters_.unexpected_sender = 10U << 24 | 7;
  counters_.unexpected_size = 512;
  tick(false);
  tick(false);
  const LidarStatus& status = tick(false);
  EXPECT_EQ(status.level, Level::kStale);
  EXPECT_EQ(status.findings.at(0).what,
            "no data on 0.0.0.0:2368 for 3.0 s; 12 datagrams rejected, the last of 512 bytes from "
            "10.0.0.7");
}

TEST_F(LidarHealthTest, LossIsRaisedAndClearedWithHysteresis) {
  settle();
  const auto tick_with_loss = [&](uint64_t packets) {
    deliver();
    counters_.lost_network += packets;
    return tick().level;
  };
  EXPECT_EQ(tick_with_loss(100), Level::kOk);  // 0.55 % of the window
  EXPECT_EQ(tick_with_loss(0), Level::kOk);
  EXPECT_EQ(tick_with_loss(0), Level::kWarn);
  EXPECT_THAT(health_.update(at(second_), counters_).findings.at(0).what, HasSubstr("(100 of"));
  int warned = 0;
  while (tick_with_loss(0) == Level::kWarn) ++warned;
  EXPECT_GE(warned, 5);  // while the loss is within the window, and for clear_after
  EXPECT_LE(warned, 14);
}

TEST_F(LidarHealthTest, HeavyLossIsAnErrorAndNamesTheKernel) {
  settle();
  Level level = Level::kOk;
  for (int i = 0; i < 5; ++i) {
    deliver(1000);
    counters_.lost_kernel += 800;
    level = tick().level;
  }
  EXPECT_EQ(level, Level::kError);
  const LidarStatus& status = tick();
  ASSERT_EQ(status.findings.size(), 1U);
  EXPECT_STREQ(status.findings[0].id, "heavy_loss");
  EXPECT_THAT(status.findings[0].advice, HasSubstr("rmem_max"));
}

TEST_F(LidarHealthTest, PacketsWithoutSweepsAreAnError) {
  settle();
  for (int i = 0; i < 3; ++i) {
    deliver(1808, 0);
    tick();
  }
  deliver(1808, 0);
  const LidarStatus& status = tick();
  EXPECT_EQ(status.level, Level::kError);
  EXPECT_STREQ(status.findings.at(0).id, "no_sweeps");
}

TEST_F(LidarHealthTest, DatagramsThatAreNotPacketsAreAnError) {
  settle();
  for (int i = 0; i < 8; ++i) {
    counters_.malformed += 4000;
    deliver();
    tick();
  }
  EXPECT_STREQ(tick().findings.at(0).id, "undecodable");
}

TEST_F(LidarHealthTest, AClockHasTenSecondsToSettle) {
  counters_.clock.reason = "too few samples";
  Stamp raised;
  for (int i = 0; i < 20 && raised == Stamp(); ++i) {
    deliver();
    const LidarStatus& status = tick();
    if (status.level == Level::kWarn) raised = status.findings.at(0).since;
  }
  EXPECT_EQ(raised, at(13));  // first packet at 1 s, 10 s of grace, 2 s of hysteresis
  EXPECT_THAT(tick().findings.at(0).what, HasSubstr("too few samples"));
}

TEST_F(LidarHealthTest, AnotherSenderIsAWarning) {
  settle();
  for (int i = 0; i < 4; ++i) {
    counters_.wrong_sender += 7;
    deliver();
    tick();
  }
  EXPECT_STREQ(tick().findings.at(0).id, "wrong_sender");
}

TEST_F(LidarHealthTest, AnotherModelIsAWarning) {
  settle();
  for (int i = 0; i < 4; ++i) {
    counters_.wrong_model += 7;
    deliver();
    tick();
  }
  EXPECT_STREQ(tick().findings.at(0).id, "wrong_model");
}

TEST_F(LidarHealthTest, SweepsThatAreNotProcessedAreAWarning) {
  settle();
  for (int i = 0; i < 4; ++i) {
    counters_.dropped_sweeps += 3;
    deliver();
    tick();
  }
  EXPECT_STREQ(tick().findings.at(0).id, "overload");
}

TEST_F(LidarHealthTest, CountersThatStepBackDoNotWrapRound) {
  settle();
  counters_.lost_network = 5;
  deliver();
  tick();
  counters_.lost_network = 4;
  for (int i = 0; i < 15; ++i) {
    deliver();
    EXPECT_LT(tick().loss, 0.001);
  }
}

TEST(HealthOptions, InvalidOptionsNameTheKey) {
  HealthOptions options;
  EXPECT_FALSE(options.invalid());
  options.error_loss = 0.0001;
  EXPECT_THAT(options.invalid().value_or(""), HasSubstr("error_loss"));
  options = HealthOptions();
  options.stale_after = Duration(0);
  EXPECT_THAT(options.invalid().value_or(""), HasSubstr("stale_after_s"));
}

TEST(Hysteresis, AShortAbsenceDoesNotClear) {
  Hysteresis state(from_seconds(2), from_seconds(3));
  EXPECT_FALSE(state.update(true, at(0)));
  EXPECT_FALSE(state.update(true, at(1)));
  EXPECT_TRUE(state.update(true, at(2)));
  EXPECT_TRUE(state.update(false, at(3)));
  EXPECT_TRUE(state.update(true, at(5)));
  EXPECT_TRUE(state.update(false, at(6)));
  EXPECT_TRUE(state.update(false, at(8)));
  EXPECT_FALSE(state.update(false, at(9)));
  EXPECT_EQ(state.raised_since(), at(2));
}

}  // namespace
}  // namespace infuse::daemon
