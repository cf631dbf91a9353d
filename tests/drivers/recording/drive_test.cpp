#include "drivers/recording/drive.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scratch_folder.hpp"

namespace infuse::recording {
namespace {

using ::testing::HasSubstr;

DriveDescription one_lidar() {
  DriveDescription description;
  description.rig.lidars.resize(1);
  description.rig.lidars[0].name = "top";
  description.lidars.resize(1);
  description.lidars[0].packets = "lidar.pcap";
  return description;
}

TEST(Drive, WriteAndOpenRoundTrip) {
  const ScratchFolder folder;
  DriveDescription description = one_lidar();
  description.truth_rig = "truth/rig.toml";
  ASSERT_TRUE(write_drive_toml(folder / "drive", description));
  folder.write("drive/lidar.pcap", "");
  folder.write("drive/truth/rig.toml", "");
  const auto drive = Drive::open(folder / "drive");
  ASSERT_TRUE(drive) << drive.error().message();
  EXPECT_EQ(drive->description.lidars[0].packets, "lidar.pcap");
  EXPECT_EQ(drive->resolve("lidar.pcap"), folder / "drive" / "lidar.pcap");
}

TEST(Drive, ErrorsNameMissingFiles) {
  const ScratchFolder folder;
  EXPECT_THAT(Drive::open(folder.path()).error().message(),
              HasSubstr("drive.toml: cannot be opened"));
  EXPECT_FALSE(Drive::open(folder / "nowhere"));
  ASSERT_TRUE(write_drive_toml(folder.path(), one_lidar()));
  EXPECT_THAT(Drive::open(folder.path()).error().message(),
              HasSubstr("lidar 'top': packets 'lidar.pcap' does not exist"));
  std::filesystem::create_directory(folder / "lidar.pcap");
  EXPECT_THAT(Drive::open(folder.path()).error().message(),
              HasSubstr("lidar 'top': packets 'lidar.pcap' must be a file"));
}

TEST(Drive, WriteRejectsInvalidDescriptions) {
  const ScratchFolder folder;
  DriveDescription description = one_lidar();
  description.name = "\xFF\xFE";
  EXPECT_FALSE(write_drive_toml(folder.path(), description));
  description = one_lidar();
  description.lidars[0].packets = "../lidar.pcap";
  EXPECT_FALSE(write_drive_toml(folder.path(), description));
  description = one_lidar();
  description.lidars.clear();
  EXPECT_FALSE(write_drive_toml(folder.path(), description));
  EXPECT_FALSE(std::filesystem::exists(folder / "drive.toml"));
}

}  // namespace
}  // namespace infuse::recording
