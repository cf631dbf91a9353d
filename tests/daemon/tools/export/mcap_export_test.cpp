#include "daemon/tools/export/mcap_export.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "drivers/gnss/gnss_csv.hpp"
#include "drivers/import/bag.hpp"
#include "drivers/import/bag_import.hpp"
#include "drivers/import/kitti_import.hpp"
#include "drivers/recording/drive_source.hpp"
#include "drivers/recording/imu_csv.hpp"
#include "drivers/recording/speed_csv.hpp"
#include "drivers/recording/sweep_files.hpp"
#include "drivers/text/text_file.hpp"
#include "fixtures/encoders/encoders.hpp"
#include "fixtures/scene/capture.hpp"
#include "tests/daemon/run_program.hpp"
#include "tests/daemon/tools/export/exported_drive.hpp"
#include "tests/folders.hpp"
#include "tests/real_data.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

struct TimedBytes {
  int64_t stamp;
  size_t sensor;
  std::string bytes;
  bool operator==(const TimedBytes&) const = default;
};

struct Contents {
  std::vector<TimedBytes> datagrams, images;
  std::vector<std::pair<size_t, Sweep>> sweeps;
  std::vector<WheelOdometry> speeds;
  std::vector<ImuSample> imu;
  std::vector<GnssFix> fixes;
  recording::DriveDescription description;
};

Contents read_drive(const fs::path& folder) {
  const auto drive = recording::Drive::open(folder);
  EXPECT_TRUE(drive) << drive.error().message();
  auto source = recording::DriveSource::open(*drive);
  EXPECT_TRUE(source) << source.error().message();
  Contents contents;
  contents.description = drive->description;
  for (recording::DriveEvent event; source->next(event);) {
    if (const auto* datagram = std::get_if<recording::DatagramEvent>(&event.content)) {
      const auto& payload = datagram->datagram.payload;
      contents.datagrams.push_back(
          {event.stamp.ns(), datagram->lidar, std::string(payload.begin(), payload.end())});
    } else if (const auto* image = std::get_if<recording::ImageEvent>(&event.content)) {
      contents.images.push_back(
          {event.stamp.ns(), image->camera, text::read_text(*image->path, 1 << 24).value_or("")});
    } else if (const auto* sweep = std::get_if<recording::SweepEvent>(&event.content)) {
      contents.sweeps.emplace_back(sweep->lidar, *sweep->sweep);
    } else if (const auto* speed = std::get_if<WheelOdometry>(&event.content)) {
      contents.speeds.push_back(*speed);
    } else if (const auto* imu = std::get_if<ImuSample>(&event.content)) {
      contents.imu.push_back(*imu);
    } else if (const auto* fix = std::get_if<GnssFix>(&event.content)) {
      contents.fixes.push_back(*fix);
    }
  }
  EXPECT_EQ(source->out_of_order_count(), 0u);
  return contents;
}

void expect_same_sweep(const Sweep& a, const Sweep& b) {
  EXPECT_EQ(a.stamp, b.stamp);
  EXPECT_EQ(a.has_times, b.has_times);
  EXPECT_EQ(a.rings, b.rings);
  EXPECT_EQ(a.columns, b.columns);
  EXPECT_TRUE(a.x == b.x && a.y == b.y && a.z == b.z && a.range == b.range);
  EXPECT_TRUE(a.reflectivity == b.reflectivity);
  EXPECT_TRUE(a.ring == b.ring && a.column == b.column);
  EXPECT_TRUE(a.time_offset_ns == b.time_offset_ns);
  EXPECT_TRUE(a.return_kind == b.return_kind);
}

void expect_same_rig(const Rig& a, const Rig& b) {
  ASSERT_EQ(a.lidars.size(), b.lidars.size());
  for (size_t k = 0; k < a.lidars.size(); ++k) {
    EXPECT_EQ(a.lidars[k].name, b.lidars[k].name);
    EXPECT_EQ(a.lidars[k].model, b.lidars[k].model);
    EXPECT_TRUE(a.lidars[k].T_vehicle_lidar.isApprox(b.lidars[k].T_vehicle_lidar, 1e-14));
  }
  ASSERT_EQ(a.cameras.size(), b.cameras.size());
  for (size_t k = 0; k < a.cameras.size(); ++k) {
    const CameraMount &left = a.cameras[k], &right = b.cameras[k];
    EXPECT_EQ(left.name, right.name);
    EXPECT_EQ(left.lidar, right.lidar);
    EXPECT_EQ(left.intrinsics.model, right.intrinsics.model);
    EXPECT_EQ(left.intrinsics.fx, right.intrinsics.fx);
    EXPECT_EQ(left.intrinsics.cy, right.intrinsics.cy);
    EXPECT_EQ(left.intrinsics.distortion, right.intrinsics.distortion);
    EXPECT_EQ(left.stamp_delay_sigma, right.stamp_delay_sigma);
    EXPECT_EQ(left.readout, right.readout);
    EXPECT_TRUE(left.T_camera_lidar.isApprox(right.T_camera_lidar, 1e-14));
  }
}

/// Equal to rounding; a standing vehicle has no course.
void expect_same_velocity(const GnssFix& a, const GnssFix& b) {
  EXPECT_EQ(std::isnan(a.speed), std::isnan(b.speed));
  if (std::isnan(a.speed)) return;
  EXPECT_NEAR(a.speed, b.speed, 1e-14 * a.speed);
  EXPECT_EQ(std::isnan(b.course), a.speed == 0);
  if (a.speed != 0) {
    EXPECT_NEAR(std::remainder(a.course - b.course, 2 * M_PI), 0, 1e-14);
  }
}

/// Exports a drive, imports the file, and expects the same measurements.
void expect_same_after_round_trip(const fs::path& drive, const ScratchFolder& folder) {
  const auto exported = export_mcap(drive, folder / "a.mcap", {});
  ASSERT_TRUE(exported) << exported.error().message();
  const auto imported = importers::import_bags({folder / "a.mcap"}, folder / "again", {});
  ASSERT_TRUE(imported) << imported.error().message();
  EXPECT_TRUE(imported->notes.empty()) << imported->notes.front().message();
  const Contents a = read_drive(drive);
  const Contents b = read_drive(folder / "again");
  expect_same_rig(a.description.rig, b.description.rig);
  EXPECT_EQ(a.datagrams, b.datagrams);
  EXPECT_EQ(a.images, b.images);
  ASSERT_EQ(a.sweeps.size(), b.sweeps.size());
  for (size_t k = 0; k < a.sweeps.size(); ++k) {
    EXPECT_EQ(a.sweeps[k].first, b.sweeps[k].first);
    expect_same_sweep(a.sweeps[k].second, b.sweeps[k].second);
  }
  ASSERT_EQ(a.speeds.size(), b.speeds.size());
  for (size_t k = 0; k < a.speeds.size(); ++k) {
    EXPECT_EQ(a.speeds[k].stamp, b.speeds[k].stamp);
    EXPECT_EQ(a.speeds[k].speed, b.speeds[k].speed);
  }
  ASSERT_EQ(a.imu.size(), b.imu.size());
  for (size_t k = 0; k < a.imu.size(); ++k) {
    EXPECT_EQ(a.imu[k].stamp, b.imu[k].stamp);
    EXPECT_EQ(a.imu[k].angular_velocity, b.imu[k].angular_velocity);
    EXPECT_EQ(a.imu[k].linear_acceleration, b.imu[k].linear_acceleration);
  }
  ASSERT_EQ(a.fixes.size(), b.fixes.size());
  for (size_t k = 0; k < a.fixes.size(); ++k) {
    EXPECT_EQ(a.fixes[k].stamp, b.fixes[k].stamp);
    EXPECT_NEAR(a.fixes[k].latitude, b.fixes[k].latitude, 1e-15);
    EXPECT_NEAR(a.fixes[k].longitude, b.fixes[k].longitude, 1e-15);
    EXPECT_EQ(a.fixes[k].valid, b.fixes[k].valid);
    expect_same_velocity(a.fixes[k], b.fixes[k]);
  }
}

TEST(McapExport, SimulatedDriveIsTheSameAfterARoundTrip) {
  const ScratchFolder folder;
  write_drive(folder / "drive");
  expect_same_after_round_trip(folder / "drive", folder);
}

/// The file holds the metadata, without which an Ouster's packets cannot be read.
TEST(McapExport, OustersPacketsAreDecodedTheSameAfterARoundTrip) {
  const ScratchFolder folder;
  const auto encoder = fixtures::make_encoder({.model = fixtures::find_model("OS1-64")});
  const std::string metadata = encoder->calibration()->text;
  ASSERT_TRUE(text::write_text(folder / "os.json", metadata));
  ASSERT_TRUE(fixtures::make_capture(
      folder / "os.pcap", {.model = fixtures::find_model("OS1-64"), .duration = kHalfSecond}));
  const auto exported = export_mcap(folder / "os.pcap", folder / "a.mcap", {});
  ASSERT_TRUE(exported) << exported.error().message();
  EXPECT_EQ(exported->messages.at("/lidar/lidar/metadata"), 1u);
  const auto imported = importers::import_bags({folder / "a.mcap"}, folder / "again", {});
  ASSERT_TRUE(imported) << imported.error().message();
  const auto again = recording::Drive::open(folder / "again");
  ASSERT_TRUE(again);
  ASSERT_EQ(again->description.lidars.size(), 1u);
  EXPECT_EQ(text::read_text(folder / "again" / again->description.lidars[0].calibration, 1 << 20),
            metadata);
  const auto second = export_mcap(folder / "again", folder / "b.mcap", {});
  ASSERT_TRUE(second) << second.error().message();
  EXPECT_GT(exported->messages.at("/lidar/lidar/packets"), 100u);
  EXPECT_EQ(exported->messages.at("/lidar/lidar/points_raw"), 6u);
  EXPECT_EQ(exported->messages, second->messages);
}

TEST(McapExport, RealKittiDriveIsTheSameAfterARoundTrip) {
  INFUSE_REAL_DATA_OR_SKIP(path, "drives/kitti_raw_0009/2011_09_26/2011_09_26_drive_0009_sync");
  const ScratchFolder folder;
  const auto imported = importers::import_kitti(path, folder / "drive");
  ASSERT_TRUE(imported) << imported.error().message();
  expect_same_after_round_trip(folder / "drive", folder);
}

/// A sweep as `infuse decode` deskews it.
Sweep deskewed_sweep(const fs::path& drive, const fs::path& file) {
  const auto result =
      run_shell_command(programs_folder() + "/infuse decode " + drive.string() +
                        " --deskew --sweep 25 -o " + file.string() + " 2>/dev/null");
  Sweep sweep;
  EXPECT_TRUE(recording::read_sweep_file(file, sweep)) << result.output;
  return sweep;
}

// By all sources of the drive. A cloud does not say when its turn ends: the lidar's motion is
// measured between times that are up to a firing earlier.
TEST(McapExport, RealKittiDriveIsDeskewedTheSameAfterARoundTrip) {
  INFUSE_REAL_DATA_OR_SKIP(path, "drives/kitti_raw_0009/2011_09_26/2011_09_26_drive_0009_sync");
  const ScratchFolder folder;
  ASSERT_TRUE(importers::import_kitti(path, folder / "drive"));
  ASSERT_TRUE(export_mcap(folder / "drive", folder / "a.mcap", {}));
  ASSERT_TRUE(importers::import_bags({folder / "a.mcap"}, folder / "again", {}));
  const Sweep before = deskewed_sweep(folder / "drive", folder / "before.pcd");
  const Sweep after = deskewed_sweep(folder / "again", folder / "after.pcd");
  ASSERT_GT(before.size(), 100'000u);
  ASSERT_EQ(before.size(), after.size());
  float worst = 0;
  for (size_t i = 0; i < before.size(); ++i) {
    worst = std::max({worst, std::abs(before.x[i] - after.x[i]), std::abs(before.y[i] - after.y[i]),
                      std::abs(before.z[i] - after.z[i])});
  }
  EXPECT_LT(worst, 2e-3F);  // m
}

}  // namespace
}  // namespace infuse::daemon
