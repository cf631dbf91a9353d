#include "fusion/motion/speed_arbiter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "tests/fusion/motion/true_drive.hpp"

namespace infuse::motion {
namespace {

constexpr OdometrySource kWheels = OdometrySource::kWheels, kGnss = OdometrySource::kGnssSpeed,
                         kLidar = OdometrySource::kLidar;

/// A speed beside a state of 10 m/s.
SpeedArbiter::Claim claim(double t, double speed, double sigma, double jump = 0) {
  return {seconds(t), speed, speed - 10, sigma, jump};
}

TEST(SpeedArbiter, NoVehicleAcceleratesBeyondTyres) {
  EXPECT_EQ(SpeedArbiter::impossible(1.2, 0.1, 0), 0);
  EXPECT_NEAR(SpeedArbiter::impossible(3, 0.1, 0.3), 1.5, 1e-12);
  EXPECT_NEAR(SpeedArbiter::impossible(-3, 0.1, 0.3), -1.5, 1e-12);
}

// Of two, the one that changed more since they agreed; whichever notices.
TEST(SpeedArbiter, OfTwoTheOneThatChangedIsWrong) {
  for (const OdometrySource changed : {kWheels, kGnss}) {
    for (const OdometrySource asks : {kWheels, kGnss}) {
      SpeedArbiter arbiter{OdometryOptions{}};
      arbiter.add(kWheels, claim(1, 10, 0.06), Duration::max());
      arbiter.add(kGnss, claim(1.01, 10.2, 0.4), Duration::max());
      EXPECT_EQ(arbiter.agreement().stamp, seconds(1.01));
      arbiter.add(kWheels, claim(2, changed == kWheels ? 13 : 10, 0.06), Duration::max());
      arbiter.add(kGnss, claim(2, changed == kGnss ? 13 : 10.1, 0.4), Duration::max());
      EXPECT_EQ(arbiter.judge(asks), asks != changed);
      EXPECT_TRUE(arbiter.is_out(changed));
      EXPECT_FALSE(arbiter.is_out(changed == kWheels ? kGnss : kWheels));
    }
  }
}

// Two sources outvote a third that changed less.
TEST(SpeedArbiter, TheMajorityIsRight) {
  SpeedArbiter arbiter{OdometryOptions{}};
  arbiter.add(kWheels, claim(1, 10, 0.06), Duration::max());
  arbiter.add(kLidar, claim(1, 10, 0.05), Duration::max());
  arbiter.add(kGnss, claim(1, 10, 0.4), Duration::max());
  arbiter.add(kGnss, claim(2, 13, 0.4), Duration::max());
  arbiter.add(kWheels, claim(2, 10, 0.06), Duration::max());
  arbiter.add(kLidar, claim(2, 13, 0.05), Duration::max());
  EXPECT_TRUE(arbiter.judge(kLidar));
  EXPECT_TRUE(arbiter.is_out(kWheels));
  EXPECT_FALSE(arbiter.is_out(kGnss));
}

TEST(SpeedArbiter, ASourceIsInAgainWhenItAgreesOrItsFaultsDoNotLastLonger) {
  SpeedArbiter arbiter{OdometryOptions{}};
  arbiter.put_out(kWheels, seconds(1));
  arbiter.add(kLidar, claim(1, 10, 0.05), Duration::max());
  arbiter.add(kWheels, claim(1.05, 11, 0.06), seconds(1) - seconds(0));
  EXPECT_TRUE(arbiter.is_out(kWheels));
  arbiter.add(kLidar, claim(1.1, 11.05, 0.05), Duration::max());
  EXPECT_FALSE(arbiter.is_out(kWheels)) << "it agrees";
  arbiter.put_out(kWheels, seconds(2));
  arbiter.add(kWheels, claim(2.9, 14, 0.06), seconds(1) - seconds(0));
  EXPECT_TRUE(arbiter.is_out(kWheels));
  arbiter.add(kWheels, claim(3.1, 14, 0.06), seconds(1) - seconds(0));
  EXPECT_FALSE(arbiter.is_out(kWheels)) << "1 s is over";
}

TEST(SpeedArbiter, AJumpIsUndoneByAJumpBack) {
  SpeedArbiter arbiter{OdometryOptions{}};
  arbiter.add(kWheels, claim(1, 0, 0.06, -8), Duration::max());
  EXPECT_TRUE(arbiter.is_out(kWheels));
  EXPECT_FALSE(arbiter.judge(kWheels)) << "what is out is not asked";
  arbiter.add(kWheels, claim(9, 3, 0.06, 3), Duration::max());
  EXPECT_TRUE(arbiter.is_out(kWheels));
  arbiter.add(kWheels, claim(10, 8, 0.06, 4), Duration::max());
  EXPECT_FALSE(arbiter.is_out(kWheels));
}

// Against the cost as the header states it, by all claims of one moment, which never agreed.
TEST(SpeedArbiter, TheLeastCostIsRight) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> speeds(8, 12), sigmas(0.05, 0.5);
  int decided = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const std::vector<OdometrySource> sources{kLidar, kWheels, OdometrySource::kSpeed, kGnss};
    SpeedArbiter arbiter{OdometryOptions{}};
    std::vector<SpeedArbiter::Claim> claims;
    for (const OdometrySource source : sources) {
      claims.push_back(claim(1, speeds(random), sigmas(random)));
      arbiter.add(source, claims.back(), Duration::max());
    }
    if (arbiter.agreement().stamp != Stamp::earliest()) continue;
    const auto apart = [&](size_t a, size_t b) {
      return std::abs(claims[a].speed - claims[b].speed) /
             std::hypot(claims[a].sigma, claims[b].sigma);
    };
    size_t right = 0;
    double least = std::numeric_limits<double>::infinity();
    for (size_t a = 0; a < 4; ++a) {
      double cost = 0;
      for (size_t b = 0; b < 4; ++b) cost += std::pow(std::min(4.0, a == b ? 0 : apart(a, b)), 2);
      if (cost < least) least = cost, right = a;
    }
    arbiter.judge(kLidar);
    ++decided;
    for (size_t a = 0; a < 4; ++a) {
      EXPECT_EQ(arbiter.is_out(sources[a]), a != right && apart(a, right) > 4) << trial;
    }
  }
  EXPECT_GT(decided, 50);
}

}  // namespace
}  // namespace infuse::motion
