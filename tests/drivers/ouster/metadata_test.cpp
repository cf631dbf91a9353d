// Metadata as sensors and recorders write it, and what hostile files say.

#include "drivers/ouster/metadata.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/measurement/angles.hpp"
#include "tests/drivers/ouster/made_metadata.hpp"

namespace infuse::ouster {
namespace {

using testing::HasSubstr;

Result<Metadata> parse(const std::string& text) { return parse_metadata(text, "os.json"); }

std::string error_of(const std::string& text) {
  const auto metadata = parse(text);
  return metadata ? "accepted" : metadata.error().message();
}

TEST(OusterMetadata, ReadsBothLayoutsAlike) {
  for (const bool nested : {false, true}) {
    const auto metadata = parse(made_metadata({.nested = nested, .extra_config = R"(,
      "timestamp_mode": "TIME_FROM_PTP_1588", "return_order": "FARTHEST_TO_NEAREST")"}));
    ASSERT_TRUE(metadata) << metadata.error().message();
    EXPECT_EQ(metadata->model(), "OS1-64");
    EXPECT_EQ(metadata->product_line, "OS-1-64");
    EXPECT_EQ(metadata->serial_number, "992110000123");
    EXPECT_EQ(metadata->firmware, "v2.3.0");
    EXPECT_EQ(metadata->profile, Profile::kRng19);
    EXPECT_EQ(metadata->columns_per_turn, 1024);
    EXPECT_EQ(metadata->columns_per_packet, 16);
    EXPECT_EQ(metadata->window.first, 0);
    EXPECT_EQ(metadata->window.last, 1023);
    EXPECT_EQ(metadata->turns_per_second, 10);
    EXPECT_EQ(metadata->time_mode, TimeMode::kPtp);
    EXPECT_EQ(metadata->first_return, FirstReturn::kFarthest);
    ASSERT_EQ(metadata->beams(), 64u);
    EXPECT_DOUBLE_EQ(metadata->elevation[0], 21.5 * kDegree);
    EXPECT_DOUBLE_EQ(metadata->azimuth[1], -1.5 * kDegree);
    EXPECT_DOUBLE_EQ(metadata->T_lidar_beam.translation().x(), 0.015806);
    EXPECT_DOUBLE_EQ(metadata->T_sensor_lidar.translation().z(), 0.03618);
    EXPECT_DOUBLE_EQ(metadata->T_sensor_lidar.linear()(0, 0), -1);
    EXPECT_DOUBLE_EQ(metadata->T_sensor_imu.translation().y(), -0.011775);
  }
}

TEST(OusterMetadata, FillsInWhatOldFirmwareLeavesOut) {
  const auto metadata = parse(R"({"prod_line": "OS-1-16-A0", "lidar_mode": "2048x10",
    "lidar_data_format": "error: Command not recognized.",
    "beam_altitude_angles": [7, 5, 3, 1, -1, -3, -5, -7],
    "beam_azimuth_angles": [1, 1, 1, 1, 1, 1, 1, 1]})");
  ASSERT_TRUE(metadata) << metadata.error().message();
  EXPECT_EQ(metadata->profile, Profile::kLegacy);
  EXPECT_EQ(metadata->columns_per_turn, 2048);
  EXPECT_EQ(metadata->columns_per_packet, 16);
  EXPECT_EQ(metadata->window_columns(), 2048);
  EXPECT_EQ(metadata->time_mode, TimeMode::kUnknown);
  EXPECT_EQ(metadata->model(), "OS1-8");
  EXPECT_DOUBLE_EQ(metadata->T_lidar_beam.translation().x(), 0.015806);
  EXPECT_DOUBLE_EQ(metadata->T_sensor_lidar.linear()(1, 1), -1);
  EXPECT_DOUBLE_EQ(metadata->T_sensor_lidar.translation().z(), 0.03618);
  EXPECT_EQ(metadata->lidar_port, 7502);
  EXPECT_EQ(metadata->imu_port, 7503);
}

TEST(OusterMetadata, ReadsWhatNewFirmwareStatesOfPackets) {
  const auto with = [](const std::string& profile, const std::string& more) {
    std::string text = made_metadata({.profile = profile});
    const std::string key = "\"udp_profile_lidar\"";
    return parse(text.replace(text.find(key), key.size(), more + ", " + key));
  };
  EXPECT_TRUE(parse(made_metadata({.profile = "FUSA_RNG15_RFL8_NIR8_DUAL"}))->fusa_header);
  EXPECT_FALSE(parse(made_metadata({.profile = "RNG15_RFL8_NIR8_DUAL"}))->fusa_header);
  EXPECT_TRUE(with("RNG15_RFL8_NIR8_DUAL", R"("header_type": "FUSA")")->fusa_header);
  EXPECT_FALSE(with("FUSA_RNG15_RFL8_NIR8_DUAL", R"("header_type": "STANDARD")")->fusa_header);
  EXPECT_FALSE(with("RNG15_RFL8_WIN8", R"("udp_profile_imu": "LEGACY")")->has_other_imu);
  EXPECT_TRUE(
      with("RNG15_RFL8_WIN8", R"("udp_profile_imu": "ACCEL32_GYRO32_NMEA")")->has_other_imu);
}

TEST(OusterMetadata, CountsTheColumnsOfAWindowThatWraps) {
  const auto metadata = parse(made_metadata({.window = "[1000, 9]"}));
  ASSERT_TRUE(metadata);
  EXPECT_EQ(metadata->window_columns(), 34);
}

TEST(OusterMetadata, RefusesWhatCannotBeTrue) {
  EXPECT_THAT(error_of("{"), HasSubstr("os.json: is no JSON object"));
  EXPECT_THAT(error_of("[]"), HasSubstr("is no JSON object"));
  EXPECT_THAT(error_of(std::string(100'000, '[')), HasSubstr("nested too deeply"));
  EXPECT_THAT(error_of(std::string((1 << 20) + 1, ' ')), HasSubstr("larger than 1 MiB"));
  EXPECT_THAT(error_of("{}"), HasSubstr("neither columns_per_frame nor lidar_mode"));
  EXPECT_THAT(error_of(R"({"lidar_mode": "1024x10"})"), HasSubstr("beam_altitude_angles"));
  EXPECT_THAT(error_of(made_metadata({.beams = 12})), HasSubstr("8, 16 ... 128"));
  EXPECT_THAT(error_of(made_metadata({.beams = 136})), HasSubstr("at most 128"));
  EXPECT_THAT(error_of(made_metadata({.window = "[0, 1024]"})),
              HasSubstr("column_window must be an integer in 0 ... 1023"));
  EXPECT_THAT(error_of(made_metadata({.window = "[0.5, 3]"})), HasSubstr("column_window"));
  EXPECT_THAT(error_of(made_metadata({.window = "7"})), HasSubstr("must have two numbers"));
  EXPECT_THAT(error_of(made_metadata({.columns = "1e9"})), HasSubstr("columns_per_frame"));
  EXPECT_THAT(error_of(made_metadata({.columns = "-1"})), HasSubstr("columns_per_frame"));
  EXPECT_THAT(error_of(made_metadata({.columns_per_packet = "0"})),
              HasSubstr("columns_per_packet must be an integer in 1 ... 16"));
  EXPECT_THAT(error_of(made_metadata({.profile = "RNG19_RFL8_SIG16_NIR16_ZM16"})),
              HasSubstr("supported: LEGACY, RNG19_RFL8_SIG16_NIR16"));
  EXPECT_THAT(error_of(made_metadata({.lidar_to_sensor = "[2,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]"})),
              HasSubstr("lidar_to_sensor_transform is no rigid motion"));
  EXPECT_THAT(error_of(made_metadata({.lidar_to_sensor = "[1,0,0,0, 0,1,0,0, 0,0,-1,0, 0,0,0,1]"})),
              HasSubstr("no rigid motion"));
  EXPECT_THAT(error_of(made_metadata({.lidar_to_sensor = "[1, 2]"})), HasSubstr("16 numbers"));
  EXPECT_THAT(error_of(made_metadata({.first_elevation = "91"})), HasSubstr("impossible"));
  EXPECT_THAT(error_of(made_metadata({.first_elevation = "\"x\""})), HasSubstr("no number"));
  EXPECT_THAT(error_of(made_metadata({.first_elevation = "1e999"})), HasSubstr("no JSON object"));
}

TEST(OusterMetadata, SaysWhichFileCannotBeRead) {
  const auto metadata = load_metadata("/nonexistent/os.json");
  ASSERT_FALSE(metadata);
  EXPECT_THAT(metadata.error().message(), HasSubstr("/nonexistent/os.json"));
}

}  // namespace
}  // namespace infuse::ouster
