#include "drivers/recording/drive_toml.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include "tests/drivers/recording/example_drive.hpp"

namespace infuse::recording {
namespace {

using ::testing::HasSubstr;

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
  EXPECT_THAT(parse_message(replace_in_drive("readout_ms = 20", "intrinsics_sigma = [0.2, -1, 0]")),
              HasSubstr("intrinsics_sigma must be three numbers: 0 ... 10 %"));
  EXPECT_THAT(
      parse_message(replace_in_drive("readout_ms = 20", "intrinsics_sigma = [0.2, 1e200, 0]")),
      HasSubstr("intrinsics_sigma must be three numbers: 0 ... 10 %"));
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
