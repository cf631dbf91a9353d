#include "daemon/view/view_profiler.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "daemon/protocol/json.hpp"
#include "tests/fusion/calibration/painted_world.hpp"

namespace infuse::daemon {
namespace {

using calibration::painted::small_camera;
using calibration::painted::true_T_camera_lidar;
using monitoring::DependenceProfile;

Eigen::Isometry3d turned(double radians) {
  return geometry::exp(radians * geometry::Vector6::Unit(1)) * true_T_camera_lidar();
}

Rig rig(const Eigen::Isometry3d& saved) {
  Rig out;
  out.lidars = {LidarMount{.name = "top"}};
  out.cameras = {CameraMount{.name = "front", .lidar = "top"}};
  out.cameras[0].intrinsics = small_camera();
  out.cameras[0].T_camera_lidar = saved;
  return out;
}

/// An image and a sweep of a simulated place, as the fusion thread has them.
struct Place {
  Place() {
    const auto world = calibration::painted::make_world(4);
    image.frame = calibration::painted::render_image(world, small_camera(), true_T_camera_lidar());
    image.frame.stamp = Stamp::from_ns(1'700'000'000'123'456'789);
    sweep = calibration::painted::scan(world, 104);
    deskewed.x = sweep.x;
    deskewed.y = sweep.y;
    deskewed.z = sweep.z;
  }
  ImageMatch match() const { return {image, {LidarIndex(0), sweep, deskewed}, in_use}; }
  CameraImage image;
  Sweep sweep;
  motion::DeskewedSweep deskewed;
  Eigen::Isometry3d in_use = true_T_camera_lidar();
};

Json header_of(const std::string& message) {
  uint32_t length = 0;
  std::memcpy(&length, message.data(), sizeof(length));
  EXPECT_EQ(message.size(), sizeof(length) + length);
  return Json::parse(message.substr(sizeof(length), length));
}

void expect_equal(const Json& axes, const DependenceProfile& profile) {
  ASSERT_EQ(axes.size(), DependenceProfile::kAxes);
  for (size_t axis = 0; axis < axes.size(); ++axis) {
    ASSERT_EQ(axes[axis].size(), DependenceProfile::kSamples);
    for (size_t k = 0; k < axes[axis].size(); ++k) {
      EXPECT_NEAR(axes[axis][k].get<double>(), profile.nats[axis][k], 1e-6);
    }
  }
}

TEST(ViewTap, ReturnsAreCopiedOnlyWhenAskedFor) {
  const Place place;
  ViewTap tap(1);
  tap.set_wanted(true);
  ViewImage image;
  tap.add_image(place.match());
  ASSERT_TRUE(tap.swap_image(CameraIndex(0), image, true));
  EXPECT_TRUE(image.returns.empty());
  EXPECT_FALSE(image.T_camera_lidar_estimate);
  const Eigen::Isometry3d estimate = turned(0.01);
  tap.add_image(place.match(), &estimate);
  ASSERT_TRUE(tap.swap_image(CameraIndex(0), image, false));
  EXPECT_EQ(image.returns.range, place.sweep.range);
  EXPECT_EQ(image.returns.column, place.sweep.column);
  EXPECT_EQ(image.returns.x, place.deskewed.x);
  ASSERT_TRUE(image.T_camera_lidar_estimate);
  EXPECT_EQ(image.T_camera_lidar_estimate->matrix(), estimate.matrix());
  for (int k = 0; k < 2; ++k) {  // both slots are used again
    tap.add_image(place.match());
    ASSERT_TRUE(tap.swap_image(CameraIndex(0), image));
    EXPECT_TRUE(image.returns.empty());
    EXPECT_FALSE(image.T_camera_lidar_estimate);
  }
}

TEST(ViewProfiler, ProfilesAreThoseOfTheMonitoringsMeasure) {
  Place place;
  place.in_use = turned(0.004);
  const Eigen::Isometry3d saved = turned(0.012), estimate = true_T_camera_lidar();
  ViewTap tap(1);
  tap.set_wanted(true);
  ViewImage image;
  tap.swap_image(CameraIndex(0), image, true);
  tap.add_image(place.match(), &estimate);
  ASSERT_TRUE(tap.swap_image(CameraIndex(0), image));
  ViewProfiler profiler(rig(saved));
  const Json header = header_of(profiler.encode(image));
  EXPECT_EQ(header["kind"], "profile");
  EXPECT_EQ(header["device"], "front");
  EXPECT_EQ(header["stamp"], "1700000000123456789");
  EXPECT_EQ(header["points"], 0);
  EXPECT_EQ(header["reason"], "");

  monitoring::ProfileSampler direct(small_camera(), {});
  ASSERT_STREQ(
      direct.prepare(place.image.frame, monitoring::make_sweep_view(place.sweep), place.in_use),
      "");
  EXPECT_EQ(header["rotation"], direct.options().rotation);
  EXPECT_EQ(header["translation"], direct.options().translation);
  EXPECT_EQ(header["profiles"].size(), 3U);
  expect_equal(header["profiles"]["use"], direct.sample(place.in_use));
  expect_equal(header["profiles"]["saved"], direct.sample(saved));
  expect_equal(header["profiles"]["estimate"], direct.sample(estimate));
}

TEST(ViewProfiler, WhatDoesNotExistIsLeftOut) {
  const Place place;
  ViewTap tap(1);
  tap.set_wanted(true);
  ViewImage image;
  tap.swap_image(CameraIndex(0), image, true);
  tap.add_image(place.match());
  ASSERT_TRUE(tap.swap_image(CameraIndex(0), image));
  ViewProfiler profiler(rig(place.in_use));
  const Json header = header_of(profiler.encode(image));
  EXPECT_EQ(header["profiles"].size(), 2U);
  EXPECT_EQ(header["profiles"]["use"], header["profiles"]["saved"]);
  image.returns = {};
  const Json empty = header_of(profiler.encode(image));
  EXPECT_EQ(empty["profiles"].size(), 0U);
  EXPECT_EQ(empty["reason"], "too few returns in view");
}

}  // namespace
}  // namespace infuse::daemon
