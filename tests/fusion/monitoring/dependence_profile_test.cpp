#include "fusion/monitoring/dependence_profile.hpp"

#include <gtest/gtest.h>

#include "drivers/measurement/angles.hpp"
#include "tests/allocation_counter.hpp"
#include "tests/fusion/calibration/painted_world.hpp"

namespace infuse::monitoring {
namespace {

using calibration::painted::small_camera;
using calibration::painted::true_T_camera_lidar;

constexpr size_t kMiddle = DependenceProfile::kSamples / 2;

struct ProfileSnapshot {
  explicit ProfileSnapshot(uint64_t seed)
      : ProfileSnapshot(calibration::painted::make_world(seed), seed) {}
  ProfileSnapshot(const calibration::painted::World& world, uint64_t seed)
      : grey(calibration::painted::render_image(world, small_camera(), true_T_camera_lidar())),
        sweep(calibration::painted::scan(world, 100 + seed)) {}
  CameraFrame grey;
  Sweep sweep;
};

/// Moves the camera along or about one of its axes, by another way than `geometry::exp`.
Eigen::Isometry3d moved(const Eigen::Isometry3d& T_camera_lidar, size_t axis, double distance) {
  const Eigen::Vector3d along = Eigen::Vector3d::Unit(static_cast<Eigen::Index>(axis % 3));
  if (axis < 3) return Eigen::AngleAxisd(distance, along) * T_camera_lidar;
  return Eigen::Translation3d(distance * along) * T_camera_lidar;
}

TEST(DependenceProfile, HoldsTheDependenceAtEachPose) {
  const ProfileSnapshot place(3);
  ProfileSampler sampler(small_camera(), {});
  const SweepView sweep = make_sweep_view(place.sweep);
  ASSERT_STREQ(sampler.prepare(place.grey, sweep, true_T_camera_lidar()), "");
  const Eigen::Isometry3d around = moved(true_T_camera_lidar(), 1, 0.4 * kDegree);
  const DependenceProfile profile = sampler.sample(around);

  const geometry::CameraModel camera(small_camera());
  const MonitorOptions options;
  features::RingDirections rings;
  MonitorImage image;
  MonitorPoints points;
  MonitorDependence dependence(options.weights);
  features::find_ring_directions(camera, true_T_camera_lidar(), 1, rings);  // 330 / 300 pixels
  image.build(place.grey, 1, rings);
  points.select(sweep, camera, true_T_camera_lidar(), options.max_points);
  for (size_t axis = 0; axis < 6; ++axis) {
    for (size_t k = 0; k < DependenceProfile::kSamples; ++k) {
      const double half_width = axis < 3 ? 0.026 : 0.25;
      const double distance = half_width * (static_cast<double>(k) - 12) / 12;
      EXPECT_NEAR(profile.nats[axis][k],
                  dependence.evaluate(moved(around, axis, distance), image.compared().fine,
                                      points.compared(), camera),
                  1e-5)
          << axis << ' ' << k;
    }
  }
}

TEST(DependenceProfile, IsHighestAtTheTruePoseOfRotations) {
  DependenceProfile mean;
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    const ProfileSnapshot place(seed);
    ProfileSampler sampler(small_camera(), {});
    // About y off by 4 samples: the maximum lies there, on the other side.
    const Eigen::Isometry3d off = moved(true_T_camera_lidar(), 1, 0.026 / 3);
    ASSERT_STREQ(sampler.prepare(place.grey, make_sweep_view(place.sweep), off), "");
    const DependenceProfile one = sampler.sample(off);
    for (size_t k = 0; k < DependenceProfile::kSamples; ++k) mean.nats[1][k] += one.nats[1][k];
  }
  const auto best = std::max_element(mean.nats[1].begin(), mean.nats[1].end());
  EXPECT_NEAR(static_cast<double>(best - mean.nats[1].begin()), kMiddle - 4.0, 1);
}

TEST(DependenceProfile, ThatOfAMovedCalibrationIsShifted) {
  const ProfileSnapshot place(2);
  ProfileSampler sampler(small_camera(), {});
  ASSERT_STREQ(sampler.prepare(place.grey, make_sweep_view(place.sweep), true_T_camera_lidar()),
               "");
  const DependenceProfile here = sampler.sample(true_T_camera_lidar());
  for (size_t axis = 0; axis < 6; ++axis) {
    EXPECT_EQ(here.nats[axis][kMiddle], here.nats[0][kMiddle]);
    const double half_width = axis < 3 ? sampler.options().rotation : sampler.options().translation;
    const DependenceProfile there =
        sampler.sample(moved(true_T_camera_lidar(), axis, half_width * 3 / 12));
    for (size_t k = 0; k + 3 < DependenceProfile::kSamples; ++k) {
      EXPECT_NEAR(there.nats[axis][k], here.nats[axis][k + 3], 1e-5) << axis << ' ' << k;
    }
  }
}

TEST(DependenceProfile, SaysWhyThereIsNone) {
  const ProfileSnapshot place(1);
  ProfileSampler sampler(small_camera(), {});
  EXPECT_STREQ(sampler.prepare(CameraFrame{}, make_sweep_view(place.sweep), true_T_camera_lidar()),
               "the image does not match the intrinsics");
  EXPECT_STREQ(sampler.prepare(place.grey, make_sweep_view(Sweep{}), true_T_camera_lidar()),
               "too few returns in view");
  Eigen::Isometry3d backwards = true_T_camera_lidar();
  backwards.prerotate(Eigen::AngleAxisd(180 * kDegree, Eigen::Vector3d::UnitY()));
  EXPECT_STREQ(sampler.prepare(place.grey, make_sweep_view(place.sweep), backwards),
               "too few returns in view");
}

TEST(DependenceProfile, AllocatesNothingOnceWarm) {
  const ProfileSnapshot place(1);
  const SweepView sweep = make_sweep_view(place.sweep);
  ProfileSampler sampler(small_camera(), {});
  for (int k = 0; k < 2; ++k) {
    sampler.prepare(place.grey, sweep, true_T_camera_lidar());
    sampler.sample(true_T_camera_lidar());
  }
  const size_t before = allocation_count();
  sampler.prepare(place.grey, sweep, true_T_camera_lidar());
  sampler.sample(true_T_camera_lidar());
  EXPECT_EQ(allocation_count(), before);
}

TEST(ProfileOptions, WidthsMustBePositive) {
  EXPECT_FALSE(ProfileOptions{}.invalid());
  EXPECT_TRUE(ProfileOptions{.rotation = 0}.invalid());
  EXPECT_TRUE(ProfileOptions{.rotation = 1}.invalid());
  EXPECT_TRUE(ProfileOptions{.translation = -1}.invalid());
}

}  // namespace
}  // namespace infuse::monitoring
