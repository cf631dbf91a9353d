#include "daemon/sensors/drive_description.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/setup/live_setup.hpp"

namespace infuse::daemon {
namespace {

DescribedDrive describe(const std::string& text) {
  const auto config = parse_config(text, "x.toml");
  EXPECT_TRUE(config.has_value()) << config.error().message();
  const auto setup = set_up_live(*config);
  EXPECT_TRUE(setup.has_value()) << setup.error().message();
  return describe_drive(*config, *setup);
}

constexpr const char* kFront = "[[lidar]]\nname = \"front\"\nmodel = \"VLP-16\"\nport = 2368\n";
constexpr const char* kRear = "[[lidar]]\nname = \"rear\"\nmodel = \"VLP-16\"\nport = 2369\n";

// What runs can be recorded: both have the default position_port.
TEST(DescribeDrive, LidarsOnTwoPortsMakeAValidDrive) {
  const DescribedDrive drive = describe(std::string(kFront) + kRear);
  EXPECT_EQ(drive.description.invalid(), std::nullopt);
  EXPECT_EQ(drive.description.lidars[0].position_port, 8308);
  EXPECT_THAT(drive.not_recorded, testing::ElementsAre(testing::HasSubstr("'rear'")));
}

TEST(DescribeDrive, ThePositionPacketsThatCarryGnssAreKept) {
  const DescribedDrive drive = describe(std::string(kFront) + kRear + "[gnss]\nlidar = \"rear\"\n");
  EXPECT_EQ(drive.description.invalid(), std::nullopt);
  EXPECT_EQ(drive.description.lidars[1].position_port, 8308);
  EXPECT_THAT(drive.not_recorded, testing::ElementsAre(testing::HasSubstr("'front'")));
}

TEST(DescribeDrive, SendersTellThemApart) {
  const DescribedDrive drive =
      describe(std::string(kFront) + "sender = \"10.0.0.1\"\n" + kRear + "sender = \"10.0.0.2\"\n");
  EXPECT_EQ(drive.description.invalid(), std::nullopt);
  EXPECT_EQ(drive.description.lidars[1].position_port, 8308);
  EXPECT_THAT(drive.not_recorded, testing::IsEmpty());
}

TEST(DescribeDrive, NamesTheSourceOfTheFixes) {
  const std::string lidar = "[[lidar]]\nname = \"a\"\nmodel = \"VLP-16\"\n";
  EXPECT_EQ(describe(lidar).description.gnss, "");
  EXPECT_EQ(describe(lidar + "[gnss]\ndevice = \"/dev/ttyUSB0\"\n").description.gnss, "gnss.csv");
  // Fixes in position packets are in lidar.pcap already.
  const auto from_packets = describe(lidar + "[gnss]\nlidar = \"a\"\n").description;
  EXPECT_EQ(from_packets.gnss, "");
  EXPECT_EQ(from_packets.gnss_lidar, "a");
}

}  // namespace
}  // namespace infuse::daemon
