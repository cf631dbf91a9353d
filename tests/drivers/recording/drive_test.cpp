#include "drivers/recording/drive.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

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
  folder.write("alone.pcap", "");
  EXPECT_THAT(Drive::open(folder / "alone.pcap").error().message(),
              HasSubstr("a drive is a folder with a drive.toml (infuse import folder"));
  ASSERT_TRUE(write_drive_toml(folder.path(), one_lidar()));
  EXPECT_THAT(Drive::open(folder.path()).error().message(),
              HasSubstr("lidar 'top': packets 'lidar.pcap' does not exist"));
  std::filesystem::create_directory(folder / "lidar.pcap");
  EXPECT_THAT(Drive::open(folder.path()).error().message(),
              HasSubstr("lidar 'top': packets 'lidar.pcap' must be a file"));
}

TEST(Drive, LinksDoNotLeadOutOfTheFolder) {
  const ScratchFolder folder;
  folder.write("secret", "");
  ASSERT_TRUE(write_drive_toml(folder / "drive", one_lidar()));
  std::filesystem::create_symlink("../secret", folder / "drive/lidar.pcap");
  EXPECT_THAT(Drive::open(folder / "drive").error().message(),
              HasSubstr("packets 'lidar.pcap' is a link out of the drive's folder"));
  std::filesystem::remove(folder / "drive/lidar.pcap");
  folder.write("drive/parts/a.pcap", "");
  std::filesystem::create_symlink("parts/a.pcap", folder / "drive/lidar.pcap");
  EXPECT_TRUE(Drive::open(folder / "drive"));
  std::filesystem::create_symlink("drive", folder / "link");  // of the user
  EXPECT_TRUE(Drive::open(folder / "link"));
}

TEST(Drive, PipesAndDevicesAreNoFiles) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_drive_toml(folder.path(), one_lidar()));
  ASSERT_EQ(::mkfifo((folder / "lidar.pcap").c_str(), 0600), 0);
  EXPECT_THAT(Drive::open(folder.path()).error().message(), HasSubstr("must be a file"));
  std::filesystem::remove(folder / "drive.toml");
  ASSERT_EQ(::mkfifo((folder / "drive.toml").c_str(), 0600), 0);
  EXPECT_THAT(Drive::open(folder.path()).error().message(), HasSubstr("is not a regular file"));
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
