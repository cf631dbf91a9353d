#include "drivers/measurement/rig.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

namespace infuse {
namespace {

using testing::HasSubstr;
using testing::Optional;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

CameraIntrinsics valid_intrinsics() {
  CameraIntrinsics intrinsics;
  intrinsics.width = 640;
  intrinsics.height = 480;
  intrinsics.fx = intrinsics.fy = 500;
  intrinsics.cx = 319.5;
  intrinsics.cy = 239.5;
  return intrinsics;
}

Rig valid_rig() {
  Rig rig;
  LidarMount roof{.name = "roof", .model = "HDL-32E"};
  roof.T_vehicle_lidar.translate(Eigen::Vector3d(1, 0, 1.8));
  LidarMount rear{.name = "rear", .model = "VLP-16"};
  rear.T_vehicle_lidar.rotate(Eigen::AngleAxisd(3.0, Eigen::Vector3d(1, 2, 3).normalized()));
  rig.lidars = {roof, rear};
  CameraMount front{.name = "front", .intrinsics = valid_intrinsics(), .lidar = "roof"};
  front.T_camera_lidar.rotate(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY()));
  rig.cameras = {front};
  return rig;
}

std::optional<std::string> intrinsics_error(const std::function<void(CameraIntrinsics&)>& change) {
  CameraIntrinsics intrinsics = valid_intrinsics();
  change(intrinsics);
  return intrinsics.invalid();
}

std::optional<std::string> rig_error(const std::function<void(Rig&)>& change) {
  Rig rig = valid_rig();
  change(rig);
  return rig.invalid();
}

TEST(CameraIntrinsics, AcceptsValidIntrinsics) {
  EXPECT_EQ(valid_intrinsics().invalid(), std::nullopt);
  // The principal point may lie outside the image, and distortion may be anything finite.
  EXPECT_EQ(intrinsics_error([](auto& k) { k.cx = -10; }), std::nullopt);
  EXPECT_EQ(intrinsics_error([](auto& k) {
              k.distortion = {-0.4, 0.2, 1e-3, -1e-3, 0};
            }),
            std::nullopt);
}

TEST(CameraIntrinsics, ReportsWhatIsInvalid) {
  EXPECT_THAT(CameraIntrinsics{}.invalid(), Optional(HasSubstr("width")));
  EXPECT_THAT(intrinsics_error([](auto& k) { k.width = 0; }), Optional(HasSubstr("width")));
  EXPECT_THAT(intrinsics_error([](auto& k) { k.height = -1; }), Optional(HasSubstr("height")));
  for (const double focal : {0.0, -500.0, kNaN, kInfinity}) {
    EXPECT_THAT(intrinsics_error([&](auto& k) { k.fx = focal; }), Optional(HasSubstr("fx")));
    EXPECT_THAT(intrinsics_error([&](auto& k) { k.fy = focal; }), Optional(HasSubstr("fy")));
  }
  for (const double bad : {kNaN, kInfinity, -kInfinity}) {
    EXPECT_THAT(intrinsics_error([&](auto& k) { k.cx = bad; }), Optional(HasSubstr("cx")));
    EXPECT_THAT(intrinsics_error([&](auto& k) { k.cy = bad; }), Optional(HasSubstr("cy")));
    for (size_t i = 0; i < 5; ++i) {
      EXPECT_THAT(intrinsics_error([&](auto& k) { k.distortion[i] = bad; }),
                  Optional(HasSubstr("distortion")));
    }
  }
}

TEST(Rig, AcceptsValidRigs) {
  EXPECT_EQ(valid_rig().invalid(), std::nullopt);
  EXPECT_EQ(Rig{}.invalid(), std::nullopt);
  // A lidar and a camera may share a name.
  EXPECT_EQ(rig_error([](Rig& rig) { rig.cameras[0].name = "rear"; }), std::nullopt);
}

TEST(Rig, ReportsWhatIsInvalidAndForWhichSensor) {
  EXPECT_THAT(rig_error([](Rig& rig) { rig.lidars[1].name = "roof"; }),
              Optional(HasSubstr("two sensors are named 'roof'")));
  EXPECT_THAT(rig_error([](Rig& rig) { rig.cameras.push_back(rig.cameras[0]); }),
              Optional(HasSubstr("two sensors are named 'front'")));
  EXPECT_THAT(rig_error([](Rig& rig) { rig.lidars[0].name = ""; }), Optional(HasSubstr("no name")));
  EXPECT_THAT(rig_error([](Rig& rig) { rig.cameras[0].name = ""; }),
              Optional(HasSubstr("no name")));
  EXPECT_THAT(rig_error([](Rig& rig) { rig.cameras[0].lidar = "rof"; }),
              Optional(AllOf(HasSubstr("'front'"), HasSubstr("'rof'"))));
  EXPECT_THAT(rig_error([](Rig& rig) { rig.cameras[0].intrinsics.fx = 0; }),
              Optional(AllOf(HasSubstr("'front'"), HasSubstr("fx"))));
}

TEST(Rig, TransformsMustBeRigid) {
  const std::vector<std::function<void(Eigen::Isometry3d&)>> spoil{
      [](Eigen::Isometry3d& T) { T.linear() *= 1.001; },
      [](Eigen::Isometry3d& T) { T.linear().col(0) *= -1; },  // a reflection
      [](Eigen::Isometry3d& T) { T.linear()(0, 1) += 0.01; },
      [](Eigen::Isometry3d& T) { T.linear().setZero(); },
      [](Eigen::Isometry3d& T) { T.translation().x() = kNaN; },
      [](Eigen::Isometry3d& T) { T.linear()(2, 2) = kInfinity; },
  };
  for (const auto& change : spoil) {
    EXPECT_THAT(rig_error([&](Rig& rig) { change(rig.lidars[1].T_vehicle_lidar); }),
                Optional(AllOf(HasSubstr("T_vehicle_lidar"), HasSubstr("'rear'"))));
    EXPECT_THAT(rig_error([&](Rig& rig) { change(rig.cameras[0].T_camera_lidar); }),
                Optional(AllOf(HasSubstr("T_camera_lidar"), HasSubstr("'front'"))));
  }
}

TEST(Rig, SensorsAreFoundByName) {
  const Rig rig = valid_rig();
  EXPECT_EQ(rig.find_lidar("rear"), &rig.lidars[1]);
  EXPECT_EQ(rig.find_camera("front"), &rig.cameras[0]);
  EXPECT_EQ(rig.find_lidar("front"), nullptr);
  EXPECT_EQ(rig.find_camera("roof"), nullptr);
}

}  // namespace
}  // namespace infuse
