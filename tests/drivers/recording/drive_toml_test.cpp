#include "drivers/recording/drive_toml.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

namespace infuse::recording {
namespace {

using ::testing::HasSubstr;

const char* const kIdentity = "[1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1]";

const char* const kDrive = R"(name = "around the block"
times = "recorded"

[[lidar]]
name = "top"
model = "HDL-32E"
packets = "lidar.pcap"
port = 2368
sender = "192.168.1.201"
T_vehicle_lidar = [
  0, -1, 0, 0.5,
  1,  0, 0, -0.25,
  0,  0, 1, 1.75,
  0,  0, 0, 1,
]

[[lidar]]
name = "rear"
sweeps = "rear"
calibration = "rear.xml"
T_vehicle_lidar = [1, 0, 0, -1,  0, 1, 0, 0,  0, 0, 1, 1,  0, 0, 0, 1]

[[camera]]
name = "left"
images = "left"
model = "fisheye"
width = 1242
height = 375
fx = 721.5
fy = 721
cx = 609.5593
cy = 172.854
distortion = [0.1, -0.02, 3e-3, 0]
lidar = "top"
T_camera_lidar = [0, -1, 0, 0.06,  0, 0, -1, 0,  1, 0, 0, -0.27,  0, 0, 0, 1]
stamp_delay_ms = 12.5
readout_ms = 20
mosaic = "gbrg"
grey = true

[can]
log = "can.log"
dbc = "vehicle.dbc"
interface = "can0"
reverse_gear = 1

[can.signals]
yaw_rate = "KINEMATICS.YAW_RATE"
wheel_speed_front_left = { signal = "WHEELS.FL", scale = -1, unit = "km/h" }

[imu]
file = "imu.csv"

[gnss]
file = "gnss.csv"

[map]
file = "map.osm"

[truth]
poses = "truth/poses.tum"
rig = "truth/rig.toml"
)";

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
    EXPECT_EQ(a.cameras[i].images, b.cameras[i].images);
    EXPECT_EQ(a.cameras[i].mosaic, b.cameras[i].mosaic);
    EXPECT_EQ(a.cameras[i].grey, b.cameras[i].grey);
  }
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
  drive->rig.cameras[0].stamp_delay = Duration(-1'234'567);
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

// Replaces the first `from` in the drive.toml above.
std::string replace_in_drive(const std::string& from, const std::string& to) {
  std::string text = kDrive;
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string parse_message(const std::string& text) {
  const auto drive = parse_drive(text);
  return drive ? "accepted" : drive.error().message();
}

TEST(DriveToml, ErrorsStateTheLineAndTheRemedy) {
  EXPECT_THAT(parse_message(replace_in_drive("model = \"HDL-32E\"", "modle = \"HDL-32E\"")),
              HasSubstr("drive.toml:6: unknown key 'modle' (known keys: name, T_vehicle_lidar"));
  EXPECT_THAT(parse_message(replace_in_drive("port = 2368", "port = 70000")),
              HasSubstr("drive.toml:8: port must be an integer from 1 to 65535"));
  EXPECT_THAT(parse_message(replace_in_drive("192.168.1.201", "192.168.1.256")),
              HasSubstr("drive.toml:9: sender"));
  EXPECT_THAT(parse_message(replace_in_drive("\"recorded\"", "\"guessed\"")),
              HasSubstr("drive.toml:2: times must be one of \"recorded\", \"synthetic\""));
  EXPECT_THAT(parse_message(replace_in_drive("0, -1, 0, 0.5", "0, -2, 0, 0.5")),
              HasSubstr("drive.toml:10: T_vehicle_lidar is not a rigid motion"));
  EXPECT_THAT(parse_message(replace_in_drive("0, -1, 0, 0.5,", "0, -1, 0,")),
              HasSubstr("T_vehicle_lidar must be 16 numbers by row (15 are given)"));
  EXPECT_THAT(parse_message(replace_in_drive("\"fisheye\"", "\"fish\"")),
              HasSubstr("drive.toml:26: model"));
  EXPECT_THAT(parse_message(replace_in_drive("width = 1242", "width = 0")),
              HasSubstr("drive.toml:27: width"));
  EXPECT_THAT(parse_message(replace_in_drive("width = 1242\n", "")),
              HasSubstr("drive.toml:23: camera has no width"));
  EXPECT_THAT(parse_message(replace_in_drive("fx = 721.5", "fx = inf")),
              HasSubstr("fx must be a finite number"));
  EXPECT_THAT(parse_message(replace_in_drive("lidar = \"top\"", "lidar = \"tip\"")),
              HasSubstr("drive.toml:23: camera 'left' refers to lidar 'tip'"));
  EXPECT_THAT(parse_message(replace_in_drive("3e-3, 0]", "3e-3, 0, 0]")),
              HasSubstr("distortion must be a list of at most 4 numbers"));
  EXPECT_THAT(parse_message(replace_in_drive("readout_ms = 20", "readout_ms = 900")),
              HasSubstr("readout_ms must be between -200 and 200"));
  EXPECT_THAT(parse_message(replace_in_drive("12.5", "1e99")),
              HasSubstr("stamp_delay_ms must lie within"));
  EXPECT_THAT(parse_message(replace_in_drive("yaw_rate =", "yaw_rat =")),
              HasSubstr("unknown key 'yaw_rat'"));
  EXPECT_THAT(parse_message(replace_in_drive("\"rear\"\nsweeps", "\"top\"\nsweeps")),
              HasSubstr("drive.toml:17: two sensors are named 'top'"));
  EXPECT_THAT(parse_message(replace_in_drive("sweeps = \"rear\"", "packets = \"lidar.pcap\"")),
              HasSubstr("drive.toml:17: lidars 'top' and 'rear' cannot be distinguished"));
  EXPECT_THAT(parse_message(replace_in_drive("[imu]", "[imu")), HasSubstr("drive.toml:"));
  EXPECT_THAT(parse_message("x = 1"), HasSubstr("drive.toml:1: unknown key 'x'"));
  EXPECT_THAT(parse_message("lidar = 3"), HasSubstr("drive.toml:1: lidar must be"));
  EXPECT_THAT(parse_message(std::string(2 << 20, '#')), HasSubstr("is longer than"));
  EXPECT_EQ(parse_message(""), "accepted");  // a drive without sensors is useless but valid
}

// Unpatched toml++ 3.3 has undefined behaviour on the rejected ones (drive_toml_fuzz).
TEST(DriveToml, NonAsciiLettersAreValidOnlyInStringsAndComments) {
  for (const char* good : {"name = \"Süd λ\"", "name = 'λ'  # λ", "\xEF\xBB\xBFname = \"λ\"",
                           "name = \"\"\"a \\\n  λ\"\"\""}) {
    EXPECT_EQ(parse_message(good), "accepted") << good;
  }
  for (const char* bad : {"\nλ = 1", "\nname λ = 1", "\nname = λ", "\nname = \"a\" λ", "\n[λ]",
                          "\nname = 2a\"\"m\"<Ļ", "\nname = \u3001", "\nname = \uFDFD"}) {
    EXPECT_THAT(parse_message(bad), HasSubstr("drive.toml:2: ")) << bad;
  }
}

TEST(DriveToml, RejectsPathsOutsideTheDrive) {
  for (const std::string path : {"/etc/passwd", "../lidar.pcap", "a/../../b", "a/.."}) {
    const std::string quoted = std::string("\"").append(path).append("\"");
    EXPECT_THAT(parse_message(replace_in_drive("\"lidar.pcap\"", quoted)),
                HasSubstr("lidar 'top': packets '" + path + "' must"));
    EXPECT_THAT(parse_message(replace_in_drive("\"map.osm\"", quoted)), HasSubstr("map: file"));
  }
  EXPECT_EQ(parse_message(replace_in_drive("\"lidar.pcap\"", "\"a/..b/c..pcap\"")), "accepted");
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

TEST(DriveToml, RigFilesRejectFileKeys) {
  const std::string head = std::string("[[lidar]]\nname = \"a\"\nT_vehicle_lidar = ") + kIdentity;
  EXPECT_TRUE(parse_rig(head));
  const auto rig = parse_rig(head + "\npackets = \"a.pcap\"");
  ASSERT_FALSE(rig);
  EXPECT_THAT(rig.error().message(), HasSubstr("rig.toml:4: unknown key 'packets'"));
}

TEST(DriveToml, MutatedFilesAreAcceptedOrRejectedWithALocation) {
  std::mt19937 random(11);
  const std::string original = kDrive;
  size_t accepted = 0, refused = 0;
  for (int round = 0; round < 10'000; ++round) {
    std::string text = original;
    for (size_t i = 0, changes = 1 + random() % 4; i < changes; ++i) {
      const size_t at = random() % text.size();
      switch (random() % 5) {
        case 4:
          text.insert(at, random() % 2 == 0 ? "λ" : "ü");
          break;
        case 0:
          text[at] = static_cast<char>(random());
          break;
        case 1:
          text.erase(at, 1 + random() % 20);
          break;
        case 2:
          text.insert(at, original.substr(random() % original.size(), random() % 40));
          break;
        default:
          text[at] = "[]{}\"'=.,#\n0-e"[random() % 14];
      }
      if (text.empty()) text.push_back('x');
    }
    const auto drive = parse_drive(text);
    if (drive) {
      ++accepted;
      ASSERT_FALSE(drive->invalid());
    } else {
      ++refused;
      ASSERT_THAT(drive.error().where, HasSubstr("drive.toml"));
      ASSERT_FALSE(drive.error().what.empty());
    }
  }
  EXPECT_GT(accepted, 100u);
  EXPECT_GT(refused, 5000u);
}

}  // namespace
}  // namespace infuse::recording
