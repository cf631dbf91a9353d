#pragma once

#include "drivers/import/bag_import.hpp"

#include <gtest/gtest.h>

#include "drivers/import/bag.hpp"
#include "drivers/recording/drive_source.hpp"
#include "tests/drivers/import/bag_messages.hpp"
#include "tests/drivers/rosbag/bag_bytes.hpp"
#include "tests/pcap_packets.hpp"
#include "tests/real_data.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::importers {

inline constexpr int64_t kSecond = 1'000'000'000;

inline ros::VelodyneScan make_scan(int64_t ns, const std::string& frame) {
  ros::VelodyneScan scan{make_header(ns, frame), {}};
  for (int k = 0; k < 3; ++k) {
    auto& packet = scan.packets.emplace_back();
    packet.stamp = ros::Time::from(Stamp::from_ns(ns + k * 1'000'000));
    packet.data.fill(static_cast<uint8_t>(k + 1));
  }
  return scan;
}

inline ros::Imu make_imu(int64_t ns, const std::string& frame) {
  ros::Imu imu{.header = make_header(ns, frame)};
  imu.angular_velocity = {0.1, 0.2, 0.3};
  imu.linear_acceleration = {1, 2, 9.8};
  return imu;
}

inline Result<BagImportSummary> import(const ScratchFolder& folder,
                                       const BagImportOptions& options = {}) {
  return import_bags({folder / "a.mcap"}, folder / "drive", options);
}

inline std::vector<recording::DriveEvent> read_samples(const std::filesystem::path& folder) {
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

}  // namespace infuse::importers
