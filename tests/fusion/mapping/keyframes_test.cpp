#include "fusion/mapping/keyframes.hpp"

#include <gtest/gtest.h>

namespace infuse::mapping {
namespace {

/// What odometry states of a step along x, turned about z, 0.1 s after the step before.
SweepMotion step(int index, double x, double turn, bool usable = true) {
  SweepMotion result;
  result.stamp = Stamp::from_ns(int64_t{index} * 100'000'000);
  result.T_from_to.translation().x() = x;
  result.T_from_to.linear() = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  result.covariance = geometry::Matrix6::Identity() * 1e-8;
  result.measured = result.registered = usable;
  return result;
}

TEST(Keyframes, ComeByDistanceAndByRotation) {
  KeyframePicker picker({.distance = 2, .rotation = 0.2});
  EXPECT_FALSE(picker.add(step(0, 0, 0, false))) << "nothing is known yet";
  std::vector<int> picked;
  for (int i = 1; i <= 9; ++i) {
    if (picker.add(step(i, 0.7, 0))) picked.push_back(i);
  }
  EXPECT_EQ(picked, (std::vector<int>{1, 4, 7}));  // 2.1 m apart
  EXPECT_NEAR(picker.last().T_odom_vehicle.translation().x(), 4.2, 1e-9);
  EXPECT_NEAR(picker.last().distance_driven, 4.2, 1e-9);
  EXPECT_TRUE(picker.add(step(10, 0, 0.21)));
  for (int i = 11; i < 30; ++i) EXPECT_FALSE(picker.add(step(i, 0, 0))) << "it stands";
}

TEST(Keyframes, StateTheDriftOfTheWayBetweenThem) {
  KeyframePicker picker({.distance = 4, .rotation_drift = 1e-3, .translation_drift = 0.02});
  for (int i = 0; i < 4; ++i) picker.add(step(i, 1, 0));
  ASSERT_TRUE(picker.add(step(4, 1, 0)));
  const geometry::Matrix6& C = picker.last().covariance;
  // The noise of the last step is 1e-4 rad and m at 3 m, negligible.
  EXPECT_NEAR(std::sqrt(C(0, 0)), 2e-3, 2e-5);
  EXPECT_NEAR(std::sqrt(C(3, 3)), 0.04, 4e-4);
}

// A gap in which the vehicle drives on as before is bridged, and makes the motion uncertain.
TEST(Keyframes, BridgeWhatWasNotMeasured) {
  KeyframePicker picker({.distance = 2, .unmeasured_translation = 3});
  for (int i = 0; i < 3; ++i) picker.add(step(i, 0.5, 0));
  EXPECT_FALSE(picker.add(step(3, 0, 0, false)));
  EXPECT_FALSE(picker.add(step(4, 0, 0, false))) << "2 m, but not measured";
  ASSERT_TRUE(picker.add(step(5, 0.5, 0)));
  EXPECT_NEAR(picker.last().T_odom_vehicle.translation().x(), 2.5, 1e-9);
  EXPECT_EQ(picker.unmeasured(), 2U);
  EXPECT_NEAR(std::sqrt(picker.last().covariance(3, 3)), 0.3 * std::sqrt(2), 0.01);
  EXPECT_FALSE(picker.add(step(6, 0.5, 0)));
}

TEST(Keyframes, SettingsSayWhatIsWrong) {
  EXPECT_FALSE(KeyframeOptions{}.invalid());
  EXPECT_TRUE(KeyframeOptions{.distance = 0}.invalid());
  EXPECT_TRUE(KeyframeOptions{.rotation_drift = 0}.invalid());
}

}  // namespace
}  // namespace infuse::mapping
