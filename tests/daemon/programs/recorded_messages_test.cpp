// A drive, replayed with `infused --mcap`, imported from that file and replayed again.

#include <gtest/gtest.h>

#include <sstream>

#include "drivers/recording/drive.hpp"
#include "drivers/recording/imu_csv.hpp"
#include "drivers/recording/speed_csv.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"
#include "fixtures/scene/capture.hpp"
#include "tests/daemon/run_program.hpp"
#include "tests/folders.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

/// Reports of a class, without what names files.
std::vector<std::string> lines_of(const std::string& reports, const std::string& report_class) {
  std::vector<std::string> lines;
  std::istringstream stream(reports);
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with("{\"class\":\"" + report_class + "\"")) lines.push_back(line);
  }
  return lines;
}

TEST(RecordedMessages, ADriveReplaysTheSameFromTheFileOfItsReplay) {
  const ScratchFolder folder;
  ASSERT_TRUE(fixtures::make_capture(folder / "top.pcap",
                                     {.model = &velodyne::lidar_model(velodyne::Model::kVlp16),
                                      .duration = Duration{3'000'000'000}}));
  std::filesystem::create_directories(folder / "drive");
  std::filesystem::rename(folder / "top.pcap", folder / "drive/top.pcap");
  recording::DriveDescription drive;
  LidarMount lidar{.name = "top", .model = "VLP-16"};
  lidar.T_vehicle_lidar.translation() = Eigen::Vector3d(0.5, 0, 1.8);
  drive.rig.lidars = {lidar};
  drive.lidars.emplace_back().packets = "top.pcap";
  drive.speed = "speed.csv";
  drive.imu = "imu.csv";
  drive.gnss_lidar = "top";
  std::vector<WheelOdometry> speeds;
  std::vector<ImuSample> imu;
  for (int k = 0; k <= 300; ++k) {
    WheelOdometry speed;
    speed.stamp = Stamp::from_ns(1'700'000'600'000'000'000 + k * 10'000'000LL);
    speed.speed = 5.5;
    speeds.push_back(speed);
    imu.push_back({speed.stamp, {0, 0, 0.1}, {0, 0, 9.81}});
  }
  ASSERT_TRUE(recording::write_speed_csv(folder / "drive/speed.csv", speeds));
  ASSERT_TRUE(recording::write_imu_csv(folder / "drive/imu.csv", imu));
  ASSERT_TRUE(recording::write_drive_toml(folder / "drive", drive));

  const std::string bin = programs_folder(), at = folder.path().string();
  const auto run = [&](const std::string& command) {
    const auto result = run_shell_command("cd " + at + " && " + bin + "/" + command + " 2>&1");
    EXPECT_EQ(result.code, 0) << command << "\n" << result.output;
  };
  run("infused --replay drive --socket s --reports first --mcap a.mcap");
  run("infuse import rosbag a.mcap --topic /vehicle/twist -o again");
  run("infused --replay again --socket s --reports second");
  const std::string first = folder.read("first"), second = folder.read("second");
  for (const char* report_class : {"SWEEP", "POSE"}) {
    const auto before = lines_of(first, report_class), after = lines_of(second, report_class);
    EXPECT_GT(before.size(), 25u) << report_class;
    EXPECT_EQ(before, after) << report_class;
  }
}

}  // namespace
}  // namespace infuse::daemon
