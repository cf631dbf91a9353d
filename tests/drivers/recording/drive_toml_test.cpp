#include "drivers/recording/drive_toml.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include "tests/drivers/recording/example_drive.hpp"

namespace infuse::recording {
namespace {

using ::testing::HasSubstr;

TEST(DriveToml, ReadsEveryKey) {
  const auto drive = parse_drive(kDrive);
  ASSERT_TRUE(drive) << drive.error().message();
  EXPECT_EQ(drive->name, "around the block");
  EXPECT_TRUE(drive->times_trusted);

  ASSERT_EQ(drive->lidars.size(), 2u);
  ASSERT_EQ(drive->rig.lidars.size(), 2u);
  EXPECT_EQ(drive->rig.lidars[0].name, "top");
  EXPECT_EQ(drive->rig.lidars[0].model, "HDL-32E");
  // By row: the lidar's x axis points along the vehicle's y axis.
  const Eigen::Vector3d moved = drive->rig.lidars[0].T_vehicle_lidar * Eigen::Vector3d(2, 0, 0);
  EXPECT_LT((moved - Eigen::Vector3d(0.5, 1.75, 1.75)).norm(), 1e-15);
  EXPECT_EQ(drive->lidars[0].packets, "lidar.pcap");
  EXPECT_EQ(drive->lidars[0].port, 2368);
  EXPECT_EQ(drive->lidars[0].position_port, 8308);
  EXPECT_EQ(drive->lidars[0].sender, 0xC0A801C9u);
  EXPECT_EQ(drive->lidars[1].sweeps, "rear");
  EXPECT_EQ(drive->lidars[1].calibration, "rear.xml");
  EXPECT_FALSE(drive->lidars[1].sender);

  ASSERT_EQ(drive->cameras.size(), 1u);
  const CameraMount& camera = drive->rig.cameras[0];
  EXPECT_EQ(camera.intrinsics.model, CameraIntrinsics::Model::kFisheye);
  EXPECT_EQ(camera.intrinsics.width, 1242);
  EXPECT_EQ(camera.intrinsics.fy, 721);
  EXPECT_EQ(camera.intrinsics.cx, 609.5593);
  EXPECT_EQ(camera.intrinsics.distortion, (std::array<double, 5>{0.1, -0.02, 3e-3, 0, 0}));
  EXPECT_EQ(camera.lidar, "top");
  EXPECT_EQ(camera.stamp_delay, Duration(12'500'000));
  EXPECT_EQ(camera.readout, Duration(20'000'000));
  EXPECT_EQ(drive->cameras[0].mosaic, PixelFormat::kBayerGbrg8);
  EXPECT_TRUE(drive->cameras[0].grey);

  ASSERT_TRUE(drive->can);
  EXPECT_EQ(drive->can->interface, "can0");
  EXPECT_EQ(drive->can->reverse_gear, 1);
  ASSERT_EQ(drive->can->signals.size(), 2u);
  EXPECT_EQ(drive->can->signals[0].quantity, "wheel_speed_front_left");
  EXPECT_EQ(drive->can->signals[0].signal, "WHEELS.FL");
  EXPECT_EQ(drive->can->signals[0].scale, -1);
  EXPECT_EQ(drive->can->signals[0].unit, "km/h");
  EXPECT_EQ(drive->can->signals[1].signal, "KINEMATICS.YAW_RATE");
  EXPECT_EQ(drive->imu, "imu.csv");
  EXPECT_EQ(drive->imu_delay, Duration(57'000'000));
  EXPECT_EQ(drive->gnss, "gnss.csv");
  EXPECT_EQ(drive->map, "map.osm");
  EXPECT_EQ(drive->truth_poses, "truth/poses.tum");
  EXPECT_EQ(drive->truth_rig, "truth/rig.toml");
}

TEST(DriveToml, PositionPacketsOfALidarMayCarryTheFixes) {
  const std::string lidar =
      "[[lidar]]\nname = \"top\"\npackets = \"lidar.pcap\"\n"
      "T_vehicle_lidar = [1,0,0,0, 0,1,0,0, 0,0,1,2, 0,0,0,1]\n";
  const auto drive = parse_drive(lidar + "[gnss]\nlidar = \"top\"\n");
  ASSERT_TRUE(drive) << drive.error().message();
  EXPECT_EQ(drive->gnss_lidar, "top");
  EXPECT_EQ(parse_drive(format_drive(*drive))->gnss_lidar, "top");
  EXPECT_FALSE(parse_drive(lidar + "[gnss]\nlidar = \"rear\"\n"));
  EXPECT_FALSE(parse_drive(lidar + "[gnss]\nlidar = \"top\"\nfile = \"gnss.csv\"\n"));
}

void expect_equal(const DriveDescription& a, const DriveDescription& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.times_trusted, b.times_trusted);
  ASSERT_EQ(a.lidars.size(), b.lidars.size());
  for (size_t i = 0; i < a.lidars.size(); ++i) {
    EXPECT_EQ(a.rig.lidars[i].name, b.rig.lidars[i].name);
    EXPECT_EQ(a.rig.lidars[i].model, b.rig.lidars[i].model);
    EXPECT_EQ(a.rig.lidars[i].T_vehicle_lidar.matrix(), b.rig.lidars[i].T_vehicle_lidar.matrix());
    EXPECT_EQ(a.lidars[i].packets, b.lidars[i].packets);
    EXPECT_EQ(a.lidars[i].sweeps, b.lidars[i].sweeps);
    EXPECT_EQ(a.lidars[i].port, b.lidars[i].port);
    EXPECT_EQ(a.lidars[i].sender, b.lidars[i].sender);
    EXPECT_EQ(a.lidars[i].calibration, b.lidars[i].calibration);
  }
  ASSERT_EQ(a.cameras.size(), b.cameras.size());
  for (size_t i = 0; i < a.cameras.size(); ++i) {
    const CameraMount &x = a.rig.cameras[i], &y = b.rig.cameras[i];
    EXPECT_EQ(x.name, y.name);
    EXPECT_EQ(x.intrinsics.model, y.intrinsics.model);
    EXPECT_EQ(x.intrinsics.fx, y.intrinsics.fx);
    EXPECT_EQ(x.intrinsics.distortion, y.intrinsics.distortion);
    EXPECT_EQ(x.T_camera_lidar.matrix(), y.T_camera_lidar.matrix());
    EXPECT_EQ(x.stamp_delay, y.stamp_delay);
    EXPECT_EQ(x.readout, y.readout);
    ASSERT_EQ(x.intrinsics_sigma.has_value(), y.intrinsics_sigma.has_value());
    if (x.intrinsics_sigma) {
      EXPECT_DOUBLE_EQ(x.intrinsics_sigma->focal_length, y.intrinsics_sigma->focal_length);
      EXPECT_EQ(x.intrinsics_sigma->principal_point, y.intrinsics_sigma->principal_point);
      EXPECT_EQ(x.intrinsics_sigma->radial, y.intrinsics_sigma->radial);
    }
    EXPECT_EQ(a.cameras[i].images, b.cameras[i].images);
    EXPECT_EQ(a.cameras[i].mosaic, b.cameras[i].mosaic);
    EXPECT_EQ(a.cameras[i].grey, b.cameras[i].grey);
  }
  EXPECT_EQ(a.imu, b.imu);
  EXPECT_EQ(a.imu_delay, b.imu_delay);
  EXPECT_EQ(a.imu_delay_sigma, b.imu_delay_sigma);
  ASSERT_EQ(a.can.has_value(), b.can.has_value());
  if (a.can) {
    ASSERT_EQ(a.can->signals.size(), b.can->signals.size());
    for (size_t i = 0; i < a.can->signals.size(); ++i) {
      EXPECT_EQ(a.can->signals[i].quantity, b.can->signals[i].quantity);
      EXPECT_EQ(a.can->signals[i].signal, b.can->signals[i].signal);
      EXPECT_EQ(a.can->signals[i].scale, b.can->signals[i].scale);
      EXPECT_EQ(a.can->signals[i].unit, b.can->signals[i].unit);
    }
  }
}

TEST(DriveToml, ReadsNamesOfEarlierVersions) {
  const auto drive = parse_drive("times = \"made up\"\n[gps]\nfile = \"gps.csv\"\n");
  ASSERT_TRUE(drive) << drive.error().message();
  EXPECT_FALSE(drive->times_trusted);
  EXPECT_EQ(drive->gnss, "gps.csv");
  EXPECT_THAT(format_drive(*drive), HasSubstr("times = \"synthetic\""));
}

TEST(DriveToml, FormatAndParseRoundTripExactly) {
  auto drive = parse_drive(kDrive);
  ASSERT_TRUE(drive);
  drive->name = "quotes \" and \\ and \n lines \x7F";
  drive->times_trusted = false;
  drive->rig.cameras[0].intrinsics.fx = 1.0 / 3;
  EXPECT_FALSE(drive->rig.cameras[0].intrinsics_sigma);
  drive->rig.cameras[0].intrinsics_sigma = {0.002, 0.6, 0.0051};
  drive->rig.cameras[0].stamp_delay = Duration(-1'234'567);
  drive->imu_delay = Duration(57'123'456);
  drive->imu_delay_sigma = Duration(3'000'000);
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int round = 0; round < 100; ++round) {
    Eigen::Isometry3d& T = drive->rig.cameras[0].T_camera_lidar;
    T = Eigen::Translation3d(normal(random), normal(random), normal(random)) *
        Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
            .normalized();
    const auto back = parse_drive(format_drive(*drive));
    ASSERT_TRUE(back) << back.error().message();
    expect_equal(*drive, *back);
    const auto rig = parse_rig(format_rig(drive->rig));
    ASSERT_TRUE(rig) << rig.error().message();
    EXPECT_EQ(rig->cameras[0].T_camera_lidar.matrix(), T.matrix());
    EXPECT_EQ(rig->lidars[1].name, "rear");
  }
}

TEST(DriveToml, RoundedRotationsAreOrthonormalised) {
  const auto drive = parse_drive(
      "[[lidar]]\nname = \"a\"\npackets = \"a.pcap\"\nT_vehicle_lidar = [0.8775826, -0.4794255, 0, "
      "1,"
      " 0.4794255, 0.8775826, 0, 2, 0, 0, 1, 3, 0, 0, 0, 1]\n");
  ASSERT_TRUE(drive) << drive.error().message();
  const Eigen::Matrix3d R = drive->rig.lidars[0].T_vehicle_lidar.linear();
  EXPECT_LT((R * R.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-14);
  EXPECT_NEAR(std::atan2(R(1, 0), R(0, 0)), 0.5, 1e-7);
}

}  // namespace
}  // namespace infuse::recording
