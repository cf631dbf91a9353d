#include "daemon/tools/calibrate/motion_uncertainty.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace infuse::daemon {
namespace {

using ::testing::HasSubstr;

geometry::Vector6 driving(double speed) {
  geometry::Vector6 twist = geometry::Vector6::Zero();
  twist[3] = speed;
  return twist;
}

ScenePairs make_pairs(std::optional<geometry::Vector6> twist, Duration sigma,
                      Duration uncompensated) {
  ScenePairs pairs;
  pairs.cameras.emplace_back().stamp_delay_sigma = sigma;
  for (int k = 0; k < 4; ++k) {
    ScenePair& pair = pairs.pairs.emplace_back();
    pair.twist = twist;
    pair.uncompensated = uncompensated;
    if (uncompensated > Duration::zero()) pair.deskew_reason = "not deskewed";
  }
  return pairs;
}

// z of the camera is x of the lidar.
Eigen::Isometry3d looking_ahead() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return T;
}

TEST(MotionUncertainty, OfADelayIsSpeedTimesItsDeviationAlongTheDriving) {
  const auto result =
      motion_uncertainty(make_pairs(driving(10), Duration(3'000'000), {}), looking_ahead());
  EXPECT_NEAR(std::sqrt(result.covariance(5, 5)), 0.03, 1e-9);
  EXPECT_NEAR(result.covariance(3, 3), 0, 1e-12);
  EXPECT_EQ(result.max_shift, 0);
  EXPECT_EQ(result.reason, "");
  EXPECT_EQ(result.note, "");
}

TEST(MotionUncertainty, MovingWithoutDeskewingIsRefusedAndContained) {
  const auto result =
      motion_uncertainty(make_pairs(driving(10), {}, Duration(50'000'000)), looking_ahead());
  EXPECT_NEAR(result.max_shift, 0.5, 1e-9);
  EXPECT_NEAR(std::sqrt(result.covariance(5, 5)), 0.5 / std::sqrt(3.0), 1e-9);
  EXPECT_THAT(result.reason, HasSubstr("can be off by 50 cm (speed times time)"));
}

TEST(MotionUncertainty, StandingWithoutDeskewingIsUsable) {
  const auto result =
      motion_uncertainty(make_pairs(driving(0.2), {}, Duration(50'000'000)), looking_ahead());
  EXPECT_NEAR(result.max_shift, 0.01, 1e-9);
  EXPECT_EQ(result.reason, "");
}

TEST(MotionUncertainty, UnknownMotionIsStated) {
  const auto result =
      motion_uncertainty(make_pairs(std::nullopt, {}, Duration(50'000'000)), looking_ahead());
  EXPECT_THAT(result.note, HasSubstr("holds if the vehicle stood"));
  EXPECT_EQ(result.covariance, geometry::Matrix6::Zero());
}

}  // namespace
}  // namespace infuse::daemon
