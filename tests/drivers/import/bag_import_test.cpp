#include "drivers/import/bag_import.hpp"

#include <gtest/gtest.h>

#include "drivers/recording/drive_source.hpp"
#include "tests/drivers/import/bag_messages.hpp"
#include "tests/drivers/import/bag_samples.hpp"
#include "tests/drivers/rosbag/bag_bytes.hpp"
#include "tests/real_data.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::importers {
namespace {

TEST(BagImport, SamplesComeInTheVehiclesAxes) {
  const ScratchFolder folder;
  BagFile bag(folder / "a.mcap");
  ros::TfMessage mounting = make_transform("base_link", "imu", 1);
  const double half = std::sqrt(0.5);
  mounting.transforms[0].transform.rotation = {0, 0, half, half};  // a quarter turn about z
  bag.write("/tf_static", 1, mounting);
  bag.write("/imu", 2 * kSecond, make_imu(2 * kSecond, "imu"));
  ros::TwistStamped twist{make_header(3 * kSecond, "base_link"), {{7, 0, 0}, {0, 0, 0.5}}};
  bag.write("/twist", 3 * kSecond, twist);
  ros::NavSatFix fix{.header = make_header(4 * kSecond, "gnss")};
  fix.latitude = 49;
  fix.longitude = 8;
  fix.altitude = 110;
  bag.write("/fix", 4 * kSecond, fix);
  bag.close();
  const auto imported = import(folder);
  ASSERT_TRUE(imported) << imported.error().message();
  const auto samples = read_samples(folder / "drive");
  ASSERT_EQ(samples.size(), 3u);
  const auto& imu = std::get<ImuSample>(samples[0].content);
  EXPECT_NEAR(imu.angular_velocity[0], -0.2, 1e-12);
  EXPECT_NEAR(imu.angular_velocity[1], 0.1, 1e-12);
  EXPECT_NEAR(imu.linear_acceleration[0], -2, 1e-12);
  EXPECT_NEAR(imu.linear_acceleration[2], 9.8, 1e-12);
  const auto& speed = std::get<WheelOdometry>(samples[1].content);
  EXPECT_EQ(speed.speed, 7);
  EXPECT_EQ(speed.yaw_rate, 0.5);
  const auto& read_fix = std::get<GnssFix>(samples[2].content);
  EXPECT_NEAR(read_fix.latitude, 49 * M_PI / 180, 1e-12);
  EXPECT_TRUE(read_fix.valid);
}

ros::NavSatFix make_fix(int64_t ns) {
  ros::NavSatFix fix{.header = make_header(ns, "gnss")};
  fix.latitude = 49;
  return fix;
}

ros::TwistStamped make_twist(int64_t ns, double x, double y, double turn = 0) {
  return {make_header(ns, "gnss"), {{x, y, 0}, {0, 0, turn}}};
}

TEST(BagImport, VelocityBesideFixesIsTheirSpeedAndCourse) {
  const ScratchFolder folder;
  BagFile bag(folder / "a.mcap");
  for (const int64_t k : {1, 2, 3}) bag.write("/ublox/fix", k * kSecond, make_fix(k * kSecond));
  // To the south-east; a little late, and another one that is nearer. The third is too far away.
  const int64_t late = kSecond + 30'000'000, later = 2 * kSecond + 40'000'000;
  ros::TwistWithCovarianceStamped velocity{make_header(late, "gnss"), {{3, -3, 0}, {}}, {}};
  bag.write("/ublox/fix_velocity", late, velocity);
  velocity = {make_header(later, "gnss"), {{9, 9, 0}, {}}, {}};
  bag.write("/ublox/fix_velocity", later, velocity);
  velocity = {make_header(2 * kSecond - 1000, "gnss"), {{-4, 0, 0}, {}}, {}};
  bag.write("/ublox/fix_velocity", 2 * kSecond, velocity);
  // Of the vehicle.
  bag.write("/vehicle/vel", kSecond, make_twist(kSecond, 7, 0.5));
  bag.close();
  const auto imported = import(folder);
  ASSERT_TRUE(imported) << imported.error().message();
  EXPECT_EQ(imported->use_of("/ublox/fix_velocity"), "speed and course of GNSS");
  EXPECT_EQ(imported->use_of("/vehicle/vel"), "speed");
  ASSERT_EQ(imported->notes.size(), 1u);
  EXPECT_EQ(imported->notes[0].what, "1 fixes have no velocity within 50 ms");
  std::vector<GnssFix> fixes;
  for (const auto& sample : read_samples(folder / "drive")) {
    if (const auto* fix = std::get_if<GnssFix>(&sample.content)) fixes.push_back(*fix);
  }
  ASSERT_EQ(fixes.size(), 3u);
  EXPECT_NEAR(fixes[0].speed, std::sqrt(18), 1e-12);
  EXPECT_NEAR(fixes[0].course, 135 * M_PI / 180, 1e-12);
  EXPECT_NEAR(fixes[1].speed, 4, 1e-12);
  EXPECT_NEAR(fixes[1].course, 270 * M_PI / 180, 1e-12);
  EXPECT_TRUE(std::isnan(fixes[2].speed));
  EXPECT_TRUE(std::isnan(fixes[2].course));
}

TEST(BagImport, SecondVelocityBesideFixesIsNotTheVehiclesSpeed) {
  const ScratchFolder folder;
  BagFile bag(folder / "a.mcap");
  bag.write("/gps/fix", kSecond, make_fix(kSecond));
  bag.write("/gps/vel", kSecond, make_twist(kSecond, 3, 4));
  bag.write("/gps/velocity", kSecond, make_twist(kSecond, 3, 4));
  bag.close();
  const auto imported = import(folder);
  ASSERT_TRUE(imported) << imported.error().message();
  EXPECT_EQ(imported->use_of("/gps/vel"), "speed and course of GNSS");
  EXPECT_EQ(imported->use_of("/gps/velocity"), "");
  EXPECT_EQ(imported->selection.reasons.at("/gps/velocity"),
            "/gps/vel is the velocity of the fixes");
  EXPECT_EQ(imported->speeds, 0u);
}

// kitti2bag's are forward and left; a driver of wheels fills x only.
TEST(BagImport, TwistsOfTheVehicleBesideFixesAreNoCourse) {
  for (const auto& twist : {make_twist(kSecond, 7, 0.5, 0.1), make_twist(kSecond, 7, 0)}) {
    const ScratchFolder folder;
    BagFile bag(folder / "a.mcap");
    bag.write("/gps/fix", kSecond, make_fix(kSecond));
    bag.write("/gps/vel", kSecond, twist);
    bag.close();
    const auto imported = import(folder);
    ASSERT_TRUE(imported) << imported.error().message();
    EXPECT_EQ(imported->use_of("/gps/vel"), "speed");
    const auto samples = read_samples(folder / "drive");
    ASSERT_EQ(samples.size(), 2u);
    for (const auto& sample : samples) {
      if (const auto* fix = std::get_if<GnssFix>(&sample.content)) {
        EXPECT_TRUE(std::isnan(fix->speed));
      }
    }
  }
}

// What infuse made of a lidar alone would come back as wheels and a yaw rate.
TEST(BagImport, OdometryThatInfuseEstimatedIsNoSource) {
  const ScratchFolder folder;
  BagFile bag(folder / "a.mcap");
  bag.write_metadata("infuse", {{"estimate /odometry/odom", "of infuse"}});
  ros::Odometry pose;
  pose.header = make_header(kSecond, "odom");
  pose.twist.linear.x = 5;
  for (const char* topic : {"/odometry/odom", "/wheels/odom"}) bag.write(topic, kSecond, pose);
  bag.close();
  const auto imported = import(folder);
  ASSERT_TRUE(imported) << imported.error().message();
  EXPECT_EQ(imported->use_of("/wheels/odom"), "speed");
  EXPECT_EQ(imported->use_of("/odometry/odom"), "");
}

TEST(BagImport, FramesThatMoveConnectNothing) {
  FrameTree frames;
  frames.add(make_transform("base_link", "lidar", 1));
  frames.add(make_transform("odom", "base_link", 1));
  frames.add(make_transform("odom", "base_link", 2));
  EXPECT_TRUE(frames.find("base_link", "lidar"));
  EXPECT_FALSE(frames.find("odom", "lidar"));
  EXPECT_FALSE(frames.find("odom", "none"));
  frames.add(make_transform("b", "a", 1));
  frames.add(make_transform("a", "b", 1));  // a circle
  EXPECT_FALSE(frames.find("a", "lidar"));
}

TEST(BagImport, AmbiguousTopicsAreAskedFor) {
  const ScratchFolder folder;
  BagFile bag(folder / "a.mcap");
  bag.write("/imu/data", 1, make_imu(kSecond, "imu"));
  bag.write("/camera/imu", 1, make_imu(kSecond, "imu"));
  bag.close();
  const auto refused = import(folder);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("/camera/imu, /imu/data"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder / "drive"));
  const auto taken = import(folder, {.topics = {"/imu/data"}});
  ASSERT_TRUE(taken) << taken.error().message();
  EXPECT_EQ(taken->use_of("/imu/data"), "inertial unit");
  EXPECT_EQ(taken->use_of("/camera/imu"), "");
  EXPECT_EQ(taken->selection.reasons.at("/camera/imu"), "--topic names another one");
  EXPECT_FALSE(import_bags({folder / "a.mcap"}, folder / "other", {.topics = {"/none"}}));
}

TEST(BagImport, RecordingWithoutAnythingForADriveIsAnError) {
  const ScratchFolder folder;
  BagFile bag(folder / "a.mcap");
  bag.write("/tf_static", 1, make_transform("a", "b", 1));
  bag.close();
  const auto refused = import(folder);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("/tf_static"), std::string::npos);
  folder.write("b.mcap", "no recording at all");
  EXPECT_FALSE(import_bags({folder / "b.mcap"}, folder / "drive", {}));
}

}  // namespace
}  // namespace infuse::importers
