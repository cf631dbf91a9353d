#include "drivers/host/device_watch.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>

namespace infuse::host {
namespace {

class DeviceWatchTest : public testing::Test {
 protected:
  DeviceWatchTest() { std::filesystem::create_directories(folder_); }
  ~DeviceWatchTest() override { std::filesystem::remove_all(folder_); }

  void make_file(const std::string& name) const { std::ofstream(folder_ / name) << ""; }

  const std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) / ("infuse-watch-" + std::to_string(getpid()));
};

TEST_F(DeviceWatchTest, ReportsTheDeviceAndNothingElse) {
  DeviceWatch watch({folder_ / "video0"});
  ASSERT_GE(watch.descriptor(), 0);
  EXPECT_FALSE(watch.consume_changes());
  make_file("video1");
  EXPECT_FALSE(watch.consume_changes());
  make_file("video0");
  EXPECT_TRUE(watch.consume_changes());
  EXPECT_FALSE(watch.consume_changes());
}

TEST_F(DeviceWatchTest, ReportsAnotherOwnerOrMode) {
  make_file("video0");
  DeviceWatch watch({folder_ / "video0"});
  ASSERT_EQ(chmod((folder_ / "video0").c_str(), 0600), 0);
  EXPECT_TRUE(watch.consume_changes());
}

TEST_F(DeviceWatchTest, FollowsFoldersThatAppearAndDisappear) {
  DeviceWatch watch({folder_ / "infuse" / "camera-7"});
  for (int round = 0; round < 2; ++round) {
    std::filesystem::create_directory(folder_ / "infuse");
    EXPECT_TRUE(watch.consume_changes());
    // udev creates the link under another name, then renames it.
    std::filesystem::create_symlink("../video0", folder_ / "infuse" / ".new");
    EXPECT_FALSE(watch.consume_changes());
    std::filesystem::rename(folder_ / "infuse" / ".new", folder_ / "infuse" / "camera-7");
    EXPECT_TRUE(watch.consume_changes());
    std::filesystem::remove_all(folder_ / "infuse");
    watch.consume_changes();
  }
}

TEST(DeviceWatch, WithoutDevicesReportsNothing) {
  DeviceWatch watch({});
  EXPECT_EQ(watch.descriptor(), -1);
  EXPECT_FALSE(watch.consume_changes());
}

}  // namespace
}  // namespace infuse::host
