#include "fusion/places/localiser.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/fusion/places/invented_map.hpp"

namespace infuse::places {
namespace {

constexpr double kStep = 1;  // m between sweeps, 10 Hz

PlaceMap whole_map() {
  static const PlaceMap made = make_map(street(), 130);
  return made;
}

/// Drives `poses` (map frame) on a street from nothing, from pose `change` on with other houses;
/// calls `check` with each result.
template <class Check>
void drive(Localiser& localiser, const InventedStreet& street,
           const std::vector<Eigen::Isometry3d>& poses, Check check, size_t change = SIZE_MAX,
           const InventedStreet& changed = InventedStreet(6)) {
  for (size_t i = 0; i < poses.size(); ++i) {
    const InventedStreet& there = i < change ? street : changed;
    const mapping::Submap sweep = there.seen_from(poses[i] * lidar_above(), i);
    mapping::SweepMotion motion;
    motion.stamp = Stamp::from_ns(static_cast<int64_t>(i + 1) * 100'000'000);
    motion.measured = motion.registered = true;
    if (i > 0) motion.T_from_to = poses[i - 1].inverse() * poses[i];
    motion.covariance = 1e-6 * geometry::Matrix6::Identity();
    const auto pose = localiser.add(sweep.points(), sweep.reflectivity, motion);
    ASSERT_TRUE(pose) << pose.error().message();
    check(*pose, poses[i]);
  }
}

std::vector<Eigen::Isometry3d> straight(double from, double to, double across, double yaw) {
  std::vector<Eigen::Isometry3d> poses;
  const double sign = to > from ? 1 : -1;
  for (double s = from; sign * (to - s) > 0; s += sign * kStep) {
    poses.push_back(on_street(s, across, yaw));
  }
  return poses;
}

TEST(Localiser, FindsTheVehicleFromNothingInEitherDirectionAndTracksIt) {
  for (const bool back : {false, true}) {
    Localiser localiser(whole_map(), lidar_above());
    const auto poses = back ? straight(110, 60, 1.5, 3.14159) : straight(40, 90, -1, 0);
    size_t tracked = 0, sweeps = 0;
    drive(localiser, street(), poses,
          [&](const LocaliserPose& pose, const Eigen::Isometry3d& truth) {
            ++sweeps;
            EXPECT_EQ(pose.usable(), *pose.reason == '\0');
            EXPECT_FALSE(sweeps <= 5 && pose.usable());
            if (!pose.usable()) return;
            ++tracked;
            const geometry::Vector6 error = geometry::log(pose.T_map_vehicle.inverse() * truth);
            EXPECT_LT(error.tail<3>().norm(), 0.1) << sweeps;
            EXPECT_LT(error.head<3>().norm(), 0.01) << sweeps;
            EXPECT_LT(error.dot(pose.covariance.ldlt().solve(error)), 30) << sweeps;
          });
    EXPECT_GE(tracked, sweeps - 20) << back;
  }
}

TEST(Localiser, IsLostOnAnotherStreetAndSaysSo) {
  Localiser localiser(whole_map(), lidar_above());
  drive(localiser, InventedStreet(6), straight(20, 60, 0, 0),
        [](const LocaliserPose& pose, const Eigen::Isometry3d&) {
          EXPECT_EQ(pose.state, LocaliserState::kLost);
          EXPECT_STRNE(pose.reason, "");
        });
}

// The same houses stand at two places of the map.
TEST(Localiser, IsNotSureWhereTwoPlacesFit) {
  Localiser localiser(make_map_twice(street(), 80), lidar_above());
  drive(localiser, street(), straight(10, 60, 0, 0),
        [](const LocaliserPose& pose, const Eigen::Isometry3d&) {
          EXPECT_EQ(pose.state, LocaliserState::kLost);
        });
}

TEST(Localiser, LeavesTheMapAndIsUnsureThenLost) {
  Localiser localiser(make_map(street(), 60), lidar_above());
  std::vector<LocaliserState> states;
  std::string reason;
  drive(localiser, street(), straight(20, 240, 0, 0),
        [&](const LocaliserPose& pose, const Eigen::Isometry3d& truth) {
          if (states.empty() || states.back() != pose.state) states.push_back(pose.state);
          if (truth.translation().x() < 235) reason = pose.reason;
        });
  using enum LocaliserState;
  EXPECT_EQ(states, (std::vector{kLost, kUnsure, kTracking, kUnsure, kLost}));
}

// The map is not of today: what the vehicle sees from 40 m on speaks against it.
TEST(Localiser, IsLostWhereTheHousesAreOthers) {
  Localiser localiser(whole_map(), lidar_above());
  std::vector<LocaliserState> states;
  std::string reason;
  size_t tracked_after = 0;
  const auto poses = straight(20, 115, 0, 0);
  drive(
      localiser, street(), poses,
      [&](const LocaliserPose& pose, const Eigen::Isometry3d& truth) {
        if (states.empty() || states.back() != pose.state) states.push_back(pose.state);
        reason = pose.reason;
        tracked_after += truth.translation().x() > 60 && pose.usable() ? 1 : 0;
      },
      40);
  using enum LocaliserState;
  EXPECT_EQ(states, (std::vector{kLost, kUnsure, kTracking, kUnsure, kLost}));
  EXPECT_LE(tracked_after, 30U);
  EXPECT_NE(reason, "");
}

TEST(Localiser, PassesOnThatAPlaceCannotBeRead) {
  PlaceMap map = make_map(street(), 60);
  map.read_cloud = [](size_t) -> Result<mapping::Submap> { return fail("damaged", "000012.pcd"); };
  Localiser localiser(std::move(map), lidar_above());
  std::string error;
  const auto poses = straight(20, 40, 0, 0);
  for (size_t i = 0; i < poses.size() && error.empty(); ++i) {
    const mapping::Submap sweep = street().seen_from(poses[i] * lidar_above(), i);
    mapping::SweepMotion motion;
    motion.stamp = Stamp::from_ns(static_cast<int64_t>(i + 1) * 100'000'000);
    motion.measured = motion.registered = true;
    if (i > 0) motion.T_from_to = poses[i - 1].inverse() * poses[i];
    const auto pose = localiser.add(sweep.points(), sweep.reflectivity, motion);
    if (!pose) error = pose.error().message();
  }
  EXPECT_NE(error.find("000012.pcd"), std::string::npos);
}

TEST(Localiser, OptionsSayWhatIsWrong) {
  EXPECT_EQ(LocaliserOptions().invalid(), std::nullopt);
  EXPECT_TRUE(LocaliserOptions{.matcher = {.candidates = 0}}.invalid());
  EXPECT_TRUE(LocaliserOptions{.confirm_distance = -1}.invalid());
}

}  // namespace
}  // namespace infuse::places
