#include "drivers/import/bag_import.hpp"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <random>

#include "drivers/camera/image_decoder.hpp"
#include "drivers/import/bag.hpp"
#include "drivers/text/text_file.hpp"
#include "fixtures/encoders/encoders.hpp"
#include "tests/drivers/import/bag_messages.hpp"
#include "tests/drivers/import/bag_samples.hpp"
#include "tests/drivers/rosbag/bag_bytes.hpp"
#include "tests/pcap_packets.hpp"
#include "tests/real_data.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::importers {
namespace {

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
