#include "drivers/import/bag_import.hpp"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <random>

#include "drivers/camera/image_decoder.hpp"
#include "drivers/import/bag.hpp"
#include "drivers/recording/drive_source.hpp"
#include "drivers/text/text_file.hpp"
#include "fixtures/encoders/encoders.hpp"
#include "tests/drivers/import/bag_messages.hpp"
#include "tests/drivers/rosbag/bag_bytes.hpp"
#include "tests/pcap_packets.hpp"
#include "tests/real_data.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::importers {
namespace {

constexpr int64_t kSecond = 1'000'000'000;

ros::VelodyneScan make_scan(int64_t ns, const std::string& frame) {
  ros::VelodyneScan scan{make_header(ns, frame), {}};
  for (int k = 0; k < 3; ++k) {
    auto& packet = scan.packets.emplace_back();
    packet.stamp = ros::Time::from(Stamp::from_ns(ns + k * 1'000'000));
    packet.data.fill(static_cast<uint8_t>(k + 1));
  }
  return scan;
}

ros::Imu make_imu(int64_t ns, const std::string& frame) {
  ros::Imu imu{.header = make_header(ns, frame)};
  imu.angular_velocity = {0.1, 0.2, 0.3};
  imu.linear_acceleration = {1, 2, 9.8};
  return imu;
}

Result<BagImportSummary> import(const ScratchFolder& folder, const BagImportOptions& options = {}) {
  return import_bags({folder / "a.mcap"}, folder / "drive", options);
}

std::vector<recording::DriveEvent> read_samples(const std::filesystem::path& folder) {
  const auto drive = recording::Drive::open(folder);
  EXPECT_TRUE(drive) << drive.error().message();
  auto source = recording::DriveSource::open(*drive);
  EXPECT_TRUE(source);
  std::vector<recording::DriveEvent> samples;
  for (recording::DriveEvent event; source->next(event);) {
    if (std::holds_alternative<WheelOdometry>(event.content) ||
        std::holds_alternative<ImuSample>(event.content) ||
        std::holds_alternative<GnssFix>(event.content))
      samples.push_back(event);
  }
  return samples;
}

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

TEST(BagImport, CameraIsRelatedToItsLidarByFrames) {
  const ScratchFolder folder;
  BagFile bag(folder / "a.mcap");
  bag.write("/tf_static", 1, make_transform("base_link", "lidar", 1, 0, 2));
  bag.write("/tf_static", 2, make_transform("base_link", "camera", 1.5, 0.25, 1));
  bag.write("/velodyne/velodyne_packets", kSecond, make_scan(kSecond, "/lidar"));
  bag.write("/left/camera_info", kSecond, make_info(4, 2));
  const std::vector<uint8_t> pixels = {1, 2, 3, 4, 99, 5, 6, 7, 8, 99};  // rows of five bytes
  bag.write("/left/image_raw", kSecond,
            ros::Image{make_header(kSecond, "camera"), 2, 4, "bayer_grbg8", 0, 5, pixels});
  bag.close();
  const auto imported = import(folder);
  ASSERT_TRUE(imported) << imported.error().message();
  EXPECT_EQ(imported->use_of("/left/image_raw"), "camera left");
  EXPECT_EQ(imported->images, 1u);
  const auto drive = recording::Drive::open(folder / "drive");
  ASSERT_TRUE(drive) << drive.error().message();
  const Rig& rig = drive->description.rig;
  EXPECT_EQ(rig.lidars.at(0).T_vehicle_lidar.translation(), Eigen::Vector3d(1, 0, 2));
  EXPECT_EQ(rig.cameras.at(0).lidar, "velodyne");
  EXPECT_EQ(rig.cameras[0].T_camera_lidar.translation(), Eigen::Vector3d(-0.5, -0.25, 1));
  EXPECT_EQ(rig.cameras[0].intrinsics.fy, 410);
  EXPECT_EQ(rig.cameras[0].intrinsics.distortion[4], 0.5);
  EXPECT_EQ(drive->description.cameras[0].mosaic, PixelFormat::kBayerGrbg8);
  const std::string png = folder.read("drive/images_left/000000.png");
  CameraFrame frame;
  ASSERT_TRUE(
      camera::decode_image({reinterpret_cast<const uint8_t*>(png.data()), png.size()}, {}, frame));
  EXPECT_EQ(frame.pixels, (std::vector<uint8_t>{1, 2, 3, 4, 5, 6, 7, 8}));
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

TEST(BagImport, StampsAreComparedWithLogTimes) {
  const ScratchFolder folder;
  BagFile bag(folder / "a.mcap");
  for (int64_t k = 1; k <= 5; ++k)
    bag.write("/imu", k * kSecond + 20'000'000, make_imu(k * kSecond, "base_link"));
  bag.write("/imu", 6 * kSecond, make_imu(0, "base_link"));
  bag.close();
  const auto imported = import(folder);
  ASSERT_TRUE(imported);
  const BagTopic* topic = imported->survey.find("/imu");
  EXPECT_NEAR(topic->lag.median, 0.02, 1e-12);
  EXPECT_EQ(topic->lag.messages, 5u);
  EXPECT_EQ(topic->stampless, 1u);
  const auto samples = read_samples(folder / "drive");
  ASSERT_EQ(samples.size(), 6u);
  EXPECT_EQ(samples[0].stamp.ns(), kSecond);
  EXPECT_EQ(samples[5].stamp.ns(), 6 * kSecond);  // its log time
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

TEST(BagImport, FolderIsReadPartByPart) {
  const ScratchFolder folder;
  std::filesystem::create_directories(folder / "bag");
  for (const int64_t k : {10, 2, 1}) {
    BagFile bag(folder / ("bag/a_" + std::to_string(k) + ".mcap"));
    bag.write("/imu", k * kSecond, make_imu(k * kSecond, "base_link"));
    bag.close();
  }
  folder.write("bag/metadata.yaml", "");
  const auto files = list_bags({folder / "bag"});
  ASSERT_TRUE(files);
  ASSERT_EQ(files->size(), 3u);
  EXPECT_EQ(files->at(1).filename(), "a_2.mcap");
  const auto imported = import_bags({folder / "bag"}, folder / "drive", {});
  ASSERT_TRUE(imported) << imported.error().message();
  EXPECT_EQ(imported->imu_samples, 3u);
  std::filesystem::create_directories(folder / "empty");
  EXPECT_FALSE(list_bags({folder / "empty"}));
}

// The same messages in a bag of ROS 1 and a database of rosbag2.
TEST(BagImport, OtherContainersAreRead) {
  const ScratchFolder folder;
  std::vector<uint8_t> bytes;
  ros::encode(make_imu(kSecond, "base_link"), ros::Encoding::kRos1, bytes);
  rosbag::BagBytes bag;
  bag.add_chunk("lz4", bag.connection(0, "/imu", "sensor_msgs/Imu") +
                           bag.message(0, 1, 0, std::string(bytes.begin(), bytes.end())));
  folder.write("a.bag", bag.bytes());
  ros::encode(make_imu(2 * kSecond, "base_link"), ros::Encoding::kCdr, bytes);
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open((folder / "b.db3").c_str(), &database), SQLITE_OK);
  std::string sql =
      "CREATE TABLE topics(id INTEGER PRIMARY KEY, name, type, serialization_format);"
      "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data);"
      "INSERT INTO topics VALUES(1, '/imu', 'sensor_msgs/msg/Imu', 'cdr');"
      "INSERT INTO messages VALUES(1, 1, 2000000000, x'";
  for (const uint8_t byte : bytes)
    sql += {"0123456789abcdef"[byte / 16], "0123456789abcdef"[byte % 16]};
  sql += "');";
  EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(database);
  const auto imported = import_bags({folder / "a.bag", folder / "b.db3"}, folder / "drive", {});
  ASSERT_TRUE(imported) << imported.error().message();
  const auto samples = read_samples(folder / "drive");
  ASSERT_EQ(samples.size(), 2u);
  for (int k = 0; k < 2; ++k) {
    EXPECT_EQ(samples[static_cast<size_t>(k)].stamp.ns(), (k + 1) * kSecond);
    const auto& imu = std::get<ImuSample>(samples[static_cast<size_t>(k)].content);
    EXPECT_EQ(imu.linear_acceleration, (std::array<double, 3>{1, 2, 9.8}));
  }
}

TEST(BagImport, RealRosbagIsDecoded) {
  INFUSE_REAL_DATA_OR_SKIP(path, "formats/mcap/evo_kiss_0_0.mcap");
  const auto survey = survey_bags({path});
  ASSERT_TRUE(survey) << survey.error().message();
  size_t messages = 0;
  for (const BagTopic& topic : survey->topics) {
    messages += topic.messages;
    EXPECT_EQ(topic.unreadable, 0u) << topic.name;
  }
  EXPECT_EQ(messages, 11468u);
}

TEST(BagImport, MutatedRecordingsNeitherCrashNorHang) {
  const ScratchFolder folder;
  BagFile bag(folder / "sound.mcap");
  bag.write("/tf_static", 1, make_transform("base_link", "lidar", 1));
  bag.write("/lidar/packets", kSecond, make_scan(kSecond, "lidar"));
  bag.write("/left/camera_info", kSecond, make_info(4, 2));
  const std::vector<uint8_t> pixels(24, 5);
  bag.write("/left/image_raw", kSecond,
            ros::Image{make_header(kSecond, "camera"), 2, 4, "bgr8", 0, 12, pixels});
  ros::PointCloud2 cloud{.header = make_header(kSecond, "ouster"), .height = 1, .width = 2};
  cloud.point_fields = {{"x", 0, 7, 1}, {"y", 4, 7, 1}, {"z", 8, 7, 1}, {"t", 12, 6, 1}};
  cloud.point_step = 16;
  cloud.row_step = 32;
  const std::vector<uint8_t> points(32, 60);
  cloud.data = points;
  bag.write("/ouster/points", kSecond, cloud);
  bag.write("/imu", kSecond, make_imu(kSecond, "imu"));
  bag.close();
  const std::string sound = folder.read("sound.mcap");
  std::mt19937 random(3);
  size_t imported = 0;
  for (int k = 0; k < 150; ++k) {
    std::string bytes = sound;
    for (size_t n = 1 + random() % 3; n > 0; --n)
      bytes[random() % bytes.size()] = static_cast<char>(random());
    folder.write("a.mcap", bytes);
    if (import(folder)) ++imported;
    std::filesystem::remove_all(folder / "drive");
  }
  EXPECT_GT(imported, 5u);
}

TEST(BagImport, PacketsOfAHesaiAndARobosenseAreTaken) {
  const ScratchFolder folder;
  const auto* xt32 = fixtures::find_model("XT32");
  const auto* helios = fixtures::find_model("RS-Helios");
  const auto hesai = fixtures::make_encoder({.model = xt32});
  const auto robosense = fixtures::make_encoder({.model = helios});
  BagFile bag(folder / "a.mcap");
  const auto information = robosense->information_packet({Duration(kSecond), true, ""});
  bag.write("/rs/packets", kSecond,
            ros::RslidarPacket{make_header(kSecond, "rs"), 1, 0, information});
  std::vector<fixtures::Echo> echoes(32, {10, 100});
  ros::PandarScan scan{make_header(kSecond, "top"), {}};
  size_t helios_packets = 1;
  for (int i = 0; i < 8 * 40; ++i) {
    const Duration time(kSecond + i * 50'000);
    const auto azimuth = static_cast<uint16_t>(i * 18);
    if (hesai->add_sequence({azimuth, time, echoes})) {
      ros::PandarPacket& packet = scan.packets.emplace_back();
      packet.stamp = ros::Time::from(Stamp::from_ns(time.count()));
      packet.size = static_cast<uint32_t>(hesai->packet().size());
      std::ranges::copy(hesai->packet(), packet.data.begin());
    }
    if (robosense->add_sequence({azimuth, time, echoes})) {
      ++helios_packets;
      bag.write("/rs/packets", time.count(),
                ros::RslidarPacket{make_header(time.count(), "rs"), 0, 0, robosense->packet()});
    }
  }
  bag.write("/top/pandar_packets", 2 * kSecond, scan);
  bag.close();
  const auto imported = import(folder);
  ASSERT_TRUE(imported) << imported.error().message();
  EXPECT_EQ(imported->packets, 40 + helios_packets);
  const auto drive = recording::Drive::open(folder / "drive");
  ASSERT_TRUE(drive);
  ASSERT_EQ(drive->description.rig.lidars.size(), 2U);
  EXPECT_EQ(drive->description.rig.lidars[0].model, "RS-Helios");
  EXPECT_EQ(drive->description.rig.lidars[1].model, "XT32");
  const auto packets = read_capture(folder / "drive" / drive->description.lidars[1].packets);
  ASSERT_EQ(packets.size(), 40U);
  EXPECT_EQ(packets[0].stamp, scan.packets[0].stamp.stamp());
  EXPECT_EQ(packets[39].payload,
            std::vector<uint8_t>(hesai->packet().begin(), hesai->packet().end()));
}

TEST(BagImport, AnOustersPacketsComeWithItsMetadataAndInertialUnit) {
  const ScratchFolder folder;
  const auto encoder = fixtures::make_encoder({.model = fixtures::find_model("OS1-64")});
  BagFile bag(folder / "a.mcap");
  bag.write("/ouster/metadata", kSecond, ros::String{encoder->calibration()->text});
  std::vector<fixtures::Echo> echoes(64, {10, 100});
  for (int i = 0; i < 160; ++i) {
    const Duration time(kSecond + i * 97'656);
    if (encoder->add_sequence({static_cast<uint16_t>(18'000 + i * 35.156), time, echoes})) {
      bag.write("/ouster/lidar_packets", time.count(), ros::OusterPacket{encoder->packet()});
      const auto inertial = encoder->inertial_packet({time, {}, {0, 0, 9.8}});
      bag.write("/ouster/imu_packets", time.count(), ros::OusterPacket{inertial});
    }
  }
  bag.close();
  const auto imported = import(folder);
  ASSERT_TRUE(imported) << imported.error().message();
  EXPECT_EQ(imported->packets, 20U);
  EXPECT_EQ(imported->use_of("/ouster/imu_packets"), "positions of the lidar ouster");
  const auto drive = recording::Drive::open(folder / "drive");
  ASSERT_TRUE(drive);
  ASSERT_EQ(drive->description.lidars.size(), 1U);
  EXPECT_EQ(drive->description.lidars[0].calibration, "ouster.json");
  EXPECT_EQ(text::read_text(folder / "drive/ouster.json", 1 << 20).value(),
            encoder->calibration()->text);
}

}  // namespace
}  // namespace infuse::importers
