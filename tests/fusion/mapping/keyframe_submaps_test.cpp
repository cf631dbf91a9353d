#include "fusion/mapping/keyframe_submaps.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace infuse::mapping {
namespace {

/// A vehicle that drives along x by 0.75 m from sweep to sweep and sees one post, which stands at
/// (20, 5, 1) in the frame of its first pose. Its lidar stands 1.5 m before the vehicle's origin.
class Drive {
 public:
  Drive() : submaps_({.distance = 2}, {.voxel_size = 0.25}, lidar()) {}

  std::optional<KeyframeSubmap> add(bool registered = true, float reflectivity = 0.4F) {
    SweepMotion motion{.stamp = Stamp::from_ns(int64_t{sweeps_} * 100'000'000),
                       .registered = registered,
                       .measured = true};
    motion.T_from_to.translation().x() = sweeps_ == 0 ? 0 : kStep;
    const std::vector<float> x{static_cast<float>(20 - kStep * sweeps_ - 1.5)}, y{5}, z{1};
    ++sweeps_;
    return submaps_.add({x, y, z}, std::vector<float>{reflectivity}, motion);
  }
  KeyframeSubmaps& submaps() { return submaps_; }

 private:
  static constexpr double kStep = 0.75;
  static Eigen::Isometry3d lidar() { return Eigen::Isometry3d(Eigen::Translation3d(1.5, 0, 0)); }
  int sweeps_ = 0;
  KeyframeSubmaps submaps_;
};

// Every third sweep is 2.25 m from the keyframe before.
TEST(KeyframeSubmaps, EndAKeyframeWhereTheNextBegins) {
  Drive drive;
  for (int k = 0; k < 3; ++k) EXPECT_FALSE(drive.add()) << k;
  EXPECT_EQ(drive.submaps().sweeps(), 3U);
  const auto first = drive.add();
  ASSERT_TRUE(first);
  EXPECT_EQ(drive.submaps().sweeps(), 1U);
  EXPECT_EQ(first->keyframe.stamp, Stamp::from_ns(0));
  ASSERT_EQ(first->submap.size(), 1U) << "the post, seen from three poses";
  EXPECT_NEAR(first->submap.x[0], 18.5, 1e-6);
  EXPECT_NEAR(first->submap.y[0], 5, 1e-6);
  EXPECT_FALSE(drive.add() || drive.add());
  const auto second = drive.add();
  ASSERT_TRUE(second);
  EXPECT_NEAR(second->keyframe.distance_driven, 2.25, 1e-9);
  ASSERT_EQ(second->submap.size(), 1U);
  EXPECT_NEAR(second->submap.x[0], 18.5 - 2.25, 1e-6);
}

TEST(KeyframeSubmaps, LeaveOutSweepsThatFitNowhere) {
  Drive drive;
  drive.add(false, 0.2F);  // its first sweep is registered to nothing, and is a keyframe
  drive.add(false, 1);
  drive.add(true, 0.6F);
  EXPECT_EQ(drive.submaps().sweeps(), 2U);
  const KeyframeSubmap taken = drive.submaps().take();
  ASSERT_EQ(taken.submap.size(), 1U);
  EXPECT_NEAR(taken.submap.reflectivity[0], 0.4, 1.0 / 255);
  EXPECT_EQ(drive.submaps().take().submap.size(), 0U) << "begun anew";
}

TEST(KeyframeSubmaps, BeginWithTheFirstMeasuredSweep) {
  KeyframeSubmaps submaps({}, {}, Eigen::Isometry3d::Identity());
  const std::vector<float> coordinates{5}, reflectivity{1};
  EXPECT_FALSE(submaps.add({coordinates, coordinates, coordinates}, reflectivity, {}));
  EXPECT_FALSE(submaps.picker().started());
  EXPECT_EQ(submaps.sweeps(), 0U);
}

}  // namespace
}  // namespace infuse::mapping
