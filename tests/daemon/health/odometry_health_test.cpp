#include "daemon/health/odometry_health.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <utility>

namespace infuse::daemon {
namespace {

OdometryStatus status_of(uint64_t wheels_accepted, uint64_t wheels_rejected) {
  OdometryStatus status;
  status.present = true;
  for (size_t i = 0; i < status.sources.size(); ++i) {
    status.sources[i].name = motion::kOdometrySourceNames[i];
  }
  status.sources[static_cast<size_t>(motion::OdometrySource::kWheels)].accepted = wheels_accepted;
  status.sources[static_cast<size_t>(motion::OdometrySource::kWheels)].rejected = wheels_rejected;
  status.sources[static_cast<size_t>(motion::OdometrySource::kLidar)].carries = true;
  return status;
}

TEST(OdometryHealth, NamesTheSourceThatContradicts) {
  OdometryHealth health{HealthOptions{}};
  Stamp now = Stamp::from_ns(0);
  for (uint64_t second = 1; second < 10; ++second) {
    now = now + from_seconds(1);
    const auto& conditions = health.update(now, status_of(50 * second, second));
    EXPECT_TRUE(conditions.findings().empty()) << "single outliers";
  }
  for (uint64_t second = 1; second < 5; ++second) {
    now = now + from_seconds(1);
    health.update(now, status_of(450, 9 + 50 * second));
  }
  const auto& findings = health.update(now + from_seconds(1), status_of(450, 300)).findings();
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_STREQ(findings[0].id, "contradiction");
  EXPECT_EQ(findings[0].what, "the motion measured by lidar is contradicted by wheels");
}

// Wheels that lock for half a second, and drive on: the alert comes 2 s later, and goes.
TEST(OdometryHealth, NamesASourceThatContradictedForAMoment) {
  OdometryHealth health{HealthOptions{}};
  uint64_t accepted = 0, rejected = 0;
  for (int second = 1; second < 20; ++second) {
    const uint64_t lies = second == 7 ? 24 : 1;
    accepted += 50 - lies;
    rejected += lies;
    const auto& findings =
        health.update(Stamp::from_ns(second * 1'000'000'000LL), status_of(accepted, rejected))
            .findings();
    EXPECT_EQ(findings.size(), second >= 9 && second < 13 ? 1U : 0U) << second;
  }
}

// A receiver at 1 Hz of which one fix is bad.
TEST(OdometryHealth, OneBadFixIsChance) {
  OdometryHealth health{HealthOptions{}};
  for (int second = 1; second < 9; ++second) {
    const uint64_t bad = second >= 4 ? 1 : 0;
    const auto& conditions = health.update(Stamp::from_ns(second * 1'000'000'000LL),
                                           status_of(static_cast<uint64_t>(second) - bad, bad));
    EXPECT_TRUE(conditions.findings().empty()) << second;
  }
}

// Errors with one mode and the stated standard deviation contradict once in 36 times at most.
TEST(OdometryHealth, ErrorsOfTheStatedSigmaAreChance) {
  std::mt19937_64 generator(1);
  for (const int rate : {1, 10, 50}) {
    OdometryHealth health{HealthOptions{}};
    std::binomial_distribution<uint64_t> outliers(static_cast<uint64_t>(rate), 1.0 / 36);
    uint64_t accepted = 0, rejected = 0;
    for (int second = 1; second < 1800; ++second) {
      const uint64_t bad = outliers(generator);
      rejected += bad;
      accepted += static_cast<uint64_t>(rate) - bad;
      const auto& found =
          health.update(Stamp::from_ns(second * 1'000'000'000LL), status_of(accepted, rejected));
      ASSERT_TRUE(found.findings().empty()) << rate << " Hz, " << second << " s";
    }
  }
}

TEST(OdometryHealth, NamesWhatContradictsAtAnyRate) {
  for (const auto& [rate, seconds] : {std::pair(1, 7), {10, 4}, {100, 3}}) {
    OdometryHealth health{HealthOptions{}};
    int told = 0;
    for (int second = 1; second <= 100 && told == 0; ++second) {
      const int right = std::min(second, 60);
      const auto& found = health.update(Stamp::from_ns(second * 1'000'000'000LL),
                                        status_of(static_cast<uint64_t>(rate * right),
                                                  static_cast<uint64_t>(rate * (second - right))));
      if (!found.findings().empty()) told = second - 60;
    }
    EXPECT_GT(told, 0) << rate << " Hz";
    EXPECT_LE(told, seconds) << rate << " Hz";
  }
}

// Most of its samples are rejected, but some still carry the motion.
TEST(OdometryHealth, NoSourceContradictsItself) {
  OdometryHealth health{HealthOptions{}};
  for (uint64_t second = 1; second < 6; ++second) {
    OdometryStatus status = status_of(10 * second, 50 * second);
    status.sources[static_cast<size_t>(motion::OdometrySource::kWheels)].carries = true;
    const auto& findings =
        health.update(Stamp::from_ns(static_cast<int64_t>(second) * 1'000'000'000), status)
            .findings();
    if (second < 5) continue;
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_EQ(findings[0].what, "the motion measured by lidar is contradicted by wheels");
  }
}

TEST(OdometryHealth, SaysWhatToAddWhenNothingSuffices) {
  OdometryHealth health{HealthOptions{}};
  OdometryStatus status = status_of(0, 0);
  status.reason = "no source of speed";
  for (int second = 1; second < 4; ++second)
    health.update(Stamp::from_ns(second * 1'000'000'000LL), status);
  const auto& findings = health.update(Stamp::from_ns(4'000'000'000LL), status).findings();
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].what, "odometry not usable: no source of speed");
  EXPECT_NE(findings[0].advice.find("GNSS"), std::string::npos);
}

}  // namespace
}  // namespace infuse::daemon
