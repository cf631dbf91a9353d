#include "fusion/places/place_selection.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace infuse::places {
namespace {

constexpr double kStep = 2, kRadius = 50;  // m

/// Keyframes of a drive, and what each of them sees.
struct Drive {
  std::vector<mapping::Keyframe> keyframes;
  std::vector<Eigen::Isometry3d> T_map_vehicle;
  std::vector<PlaceDescriptor> places;

  void add(const Eigen::Vector3d& position, double heading, int first_sector, int sectors) {
    mapping::Keyframe keyframe;
    keyframe.stamp = Stamp::from_ns(static_cast<int64_t>(keyframes.size()) * 1'000'000'000);
    keyframes.push_back(keyframe);
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    T.translation() = position;
    T_map_vehicle.push_back(T);
    PlaceDescriptor place;
    for (int i = 0; i < sectors; ++i)
      place.heights.col((first_sector + i + kSectors) % kSectors).setConstant(3);
    places.push_back(place);
  }

  /// Once around, `aside` m from the circle, at a height.
  void add_lap(double aside, double height) {
    for (double way = 0; way < 2 * std::numbers::pi * kRadius; way += kStep) {
      const double angle = way / kRadius;
      const Eigen::Vector3d direction(std::cos(angle), std::sin(angle), 0);
      add((kRadius + aside) * direction + Eigen::Vector3d(0, 0, height),
          angle + std::numbers::pi / 2, 0, kSectors);
    }
  }

  std::vector<size_t> select(const PlaceSelectionOptions& options = {}) const {
    return select_places(keyframes, T_map_vehicle, places, options);
  }
};

// The tenth lap adds nothing to the first; what is kept is of the last; every place is near one
// that is kept.
TEST(PlaceSelection, GrowsWithTheAreaAndNotWithTheLaps) {
  Drive drive;
  drive.add_lap(0, 0);
  const size_t lap = drive.keyframes.size(), of_one = drive.select().size();
  EXPECT_LE(of_one, lap / 2 + 1);
  for (int i = 1; i < 10; ++i) drive.add_lap(i % 2 == 0 ? 0.3 : -0.3, 0.05 * i);
  const std::vector<size_t> kept = drive.select();
  EXPECT_LE(kept.size(), of_one + 2);
  for (const size_t k : kept) EXPECT_GE(k, 9 * lap);
  for (const Eigen::Isometry3d& T : drive.T_map_vehicle) {
    double nearest = 1e9;
    for (const size_t k : kept)
      nearest = std::min(nearest,
                         (drive.T_map_vehicle[k].translation() - T.translation()).head<2>().norm());
    EXPECT_LT(nearest, PlaceSelectionOptions().distance);
  }
}

TEST(PlaceSelection, KeepsOtherLevelsAndWhatHasNoCloudIsNotThere) {
  Drive drive;
  drive.add_lap(0, 0);
  const size_t lap = drive.keyframes.size(), of_one = drive.select().size();
  drive.add_lap(0, 6);
  EXPECT_EQ(drive.select().size(), 2 * of_one);
  for (size_t k = lap; k < 2 * lap; ++k) drive.keyframes[k].has_cloud = false;
  const std::vector<size_t> kept = drive.select();
  EXPECT_EQ(kept.size(), of_one);
  EXPECT_LT(kept.back(), lap);
}

// A lidar that looks ahead: against the direction it sees what the first visit did not.
TEST(PlaceSelection, KeepsWhatLooksElsewhere) {
  for (const bool against : {false, true}) {
    Drive drive;
    drive.add({0, 0, 0}, 0.4, -10, 20);
    drive.add({1, 0, 0}, against ? 0.4 + std::numbers::pi : 0.4, -10, 20);
    EXPECT_EQ(drive.select().size(), against ? 2U : 1U);
  }
  // Turned by 30°, both see 15 of the 20 sectors; a view of the whole circle replaces both.
  Drive drive;
  drive.add({0, 0, 0}, 0, -10, 20);
  drive.add({0, 1, 0}, std::numbers::pi / 6, -10, 20);
  EXPECT_EQ(drive.select().size(), 2U);
  drive.add({0, 0.5, 0}, 2, 0, kSectors);
  EXPECT_EQ(drive.select(), std::vector<size_t>{2});
}

}  // namespace
}  // namespace infuse::places
