#include "daemon/tools/export/mcap_export.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "daemon/ros/report_messages.hpp"
#include "drivers/camera/png_encoder.hpp"
#include "drivers/gnss/gnss_csv.hpp"
#include "drivers/import/bag.hpp"
#include "drivers/import/bag_import.hpp"
#include "drivers/import/kitti_import.hpp"
#include "drivers/recording/drive_source.hpp"
#include "drivers/recording/imu_csv.hpp"
#include "drivers/recording/speed_csv.hpp"
#include "drivers/recording/sweep_export.hpp"
#include "drivers/recording/sweep_files.hpp"
#include "drivers/recording/times_csv.hpp"
#include "drivers/text/text_file.hpp"
#include "fixtures/encoders/encoders.hpp"
#include "fixtures/scene/capture.hpp"
#include "tests/daemon/run_program.hpp"
#include "tests/folders.hpp"
#include "tests/real_data.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

namespace fs = std::filesystem;

constexpr Duration kHalfSecond{500'000'000};
constexpr int64_t kStart = 1'700'000'600'000'000'000;  // of a fixture's capture

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

Eigen::Isometry3d make_motion(double angle) {
  return Eigen::Translation3d(1.25, -angle, 1.8) *
         Eigen::AngleAxisd(angle, Eigen::Vector3d(1, 2, -1).normalized());
}

/// A sweep as another lidar's driver delivers it: 16 rings, 60 columns, times by column.
Sweep make_sweep(int64_t stamp) {
  constexpr size_t kRings = 16, kColumns = 60;
  Sweep sweep;
  sweep.stamp = Stamp::from_ns(stamp);
  sweep.rings = kRings;
  sweep.columns = kColumns;
  sweep.resize(kRings * kColumns);
  for (size_t i = 0; i < sweep.size(); ++i) {
    const auto ring = static_cast<uint16_t>(i % kRings);
    const auto column = static_cast<uint16_t>(i / kRings);
    const float azimuth = -0.1f * column;
    sweep.x[i] = 8 * std::cos(azimuth);
    sweep.y[i] = 8 * std::sin(azimuth);
    sweep.z[i] = 0.2f * static_cast<float>(ring) - 1.5f;
    sweep.range[i] =
        std::sqrt(sweep.x[i] * sweep.x[i] + sweep.y[i] * sweep.y[i] + sweep.z[i] * sweep.z[i]);
    sweep.reflectivity[i] = static_cast<float>(i % 100) / 100;
    sweep.ring[i] = ring;
    sweep.column[i] = column;
    sweep.time_offset_ns[i] = column * 1'500'000 + ring * 1000;
    sweep.return_kind[i] = ReturnKind::kBoth;
  }
  return sweep;
}

/// A drive of a second: an HDL-32E with packets, another lidar with sweeps, a camera that refers to
/// it, speed, inertial unit and GNSS.
void write_drive(const fs::path& drive) {
  recording::DriveDescription description;
  description.rig.lidars = {{.name = "rear", .T_vehicle_lidar = make_motion(0.3)},
                            {.name = "top", .model = "HDL-32E", .T_vehicle_lidar = make_motion(1)}};
  description.lidars = {{.sweeps = "rear"}, {.packets = "top.pcap"}};
  CameraMount camera{.name = "left", .lidar = "rear", .T_camera_lidar = make_motion(2)};
  camera.intrinsics = {.width = 4, .height = 2, .fx = 3, .fy = 3.5, .cx = 1.25, .cy = 0.75};
  camera.intrinsics.distortion = {0.1, -0.2, 0.003, 0.004, 0.5};
  camera.stamp_delay_sigma = Duration(3'000'000);
  camera.readout = Duration(-18'000'000);
  description.rig.cameras = {camera};
  description.cameras = {{.images = "left"}};
  description.speed = "speed.csv";
  description.imu = "imu.csv";
  description.gnss = "gnss.csv";

  fs::create_directories(drive / "rear");
  fs::create_directories(drive / "left");
  ASSERT_TRUE(fixtures::make_capture(drive / "top.pcap", {.duration = Duration(500'000'000)}));
  std::vector<recording::TimesRow> rows;
  std::vector<Stamp> exposures;
  std::vector<WheelOdometry> speeds;
  std::vector<ImuSample> imu;
  std::vector<GnssFix> fixes;
  CameraFrame frame{.width = 4, .height = 2, .format = PixelFormat::kBgr8};
  for (int k = 0; k < 4; ++k) {
    const Stamp stamp = Stamp::from_ns(kStart + k * 100'000'000);
    const Sweep sweep = make_sweep(stamp.ns());
    const std::string name = "00000" + std::to_string(k);
    ASSERT_TRUE(recording::export_sweep(sweep, drive / "rear" / (name + ".pcd"),
                                        recording::SweepFormat::kPcd));
    rows.push_back({.stamp = stamp, .end = stamp + Duration(sweep.time_offset_ns.back())});
    frame.pixels.assign(24, static_cast<uint8_t>(k));
    const auto png = camera::encode_png(frame);
    ASSERT_TRUE(png);
    ASSERT_TRUE(text::write_text(drive / "left" / (name + ".png"),
                                 {reinterpret_cast<const char*>(png->data()), png->size()}));
    exposures.push_back(stamp + Duration(50'000'001));
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    speeds.push_back({stamp, {kNan, kNan, kNan, kNan}, kNan, kNan, 1.1 * k});
    imu.push_back({stamp + Duration(7), {0.1, 0.2 * k, 0.3}, {1, 2, 9.81}});
    fixes.push_back({.stamp = stamp + Duration(9), .latitude = 0.85, .longitude = 0.14 + 1e-7 * k});
    fixes.back().valid = k > 0;
    fixes.back().speed = k == 0 ? kNan : k == 1 ? 0 : 11.1 + k;  // 0: no fix, 1: stands
    fixes.back().course = k == 0 ? kNan : 3 * k + 0.3;           // 2 and 3: either side of north
  }
  ASSERT_TRUE(recording::write_times(drive / "rear" / "times.csv", rows));
  ASSERT_TRUE(recording::write_times(drive / "left" / "times.csv", exposures));
  ASSERT_TRUE(recording::write_speed_csv(drive / "speed.csv", speeds));
  ASSERT_TRUE(recording::write_imu_csv(drive / "imu.csv", imu));
  ASSERT_TRUE(gnss::write_gnss_csv(drive / "gnss.csv", fixes));
  ASSERT_TRUE(recording::write_drive_toml(drive, description));
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

TEST(McapExport, RecoveredFileHasTheMessagesOfTheCutOne) {
  const ScratchFolder folder;
  write_drive(folder / "drive");
  const auto whole = export_mcap(folder / "drive", folder / "a.mcap", {});
  ASSERT_TRUE(whole);
  const std::string bytes = folder.read("a.mcap");
  folder.write("cut.mcap", bytes.substr(0, bytes.size() * 9 / 10));
  const auto recovered = recover_mcap(folder / "cut.mcap", folder / "whole.mcap");
  ASSERT_TRUE(recovered) << recovered.error().message();
  EXPECT_EQ(recovered->notes.size(), 1u);
  EXPECT_FALSE(recover_mcap(folder / "cut.mcap", folder / "cut.mcap"));
  EXPECT_FALSE(recover_mcap(folder / "drive/drive.toml", folder / "b.mcap"));
  const auto bag = importers::open_bag(folder / "whole.mcap");
  ASSERT_TRUE(bag);
  std::map<std::string, size_t> messages;
  importers::BagMessage message;
  while ((*bag)->next(message)) ++messages[std::string(message.topic)];
  EXPECT_EQ(messages, recovered->messages);
  std::vector<Error> notes;
  (*bag)->append_notes(notes);
  EXPECT_TRUE(notes.empty());
}

TEST(McapExport, ReportsBecomePosesAndDiagnostics) {
  const ScratchFolder folder;
  write_drive(folder / "drive");
  std::string covariance = "1e-4";
  for (int k = 1; k < 36; ++k) covariance += k % 7 == 0 ? ",1e-4" : ",0";
  const std::string pose =
      R"(,"T_frame_vehicle":[1,0,0,5,0,1,0,6,0,0,1,0,0,0,0,1],"covariance":[)" + covariance +
      R"(],"speed":3,"yaw_rate":0.1})";
  folder.write(
      "reports.jsonl",
      R"({"class":"VERSION"})"
      "\n" +
          (R"({"class":"POSE","stamp":1700000600000000000,"frame":"odom","usable":true)" + pose) +
          "\n" +
          (R"({"class":"POSE","stamp":1700000600000000001,"frame":"map","usable":false)" + pose) +
          "\n"
          R"({"class":"ALERT","stamp":1700000600000000002,"id":"a","device":"top",)"
          R"("severity":"WARN","state":"raised","since":1,"what":"w","advice":"d"})"
          "\nnot a report\n");
  const auto exported =
      export_mcap(folder / "drive", folder / "a.mcap", {.reports = folder / "reports.jsonl"});
  ASSERT_TRUE(exported) << exported.error().message();
  EXPECT_EQ(exported->messages.at("/odometry/odom"), 1u);
  EXPECT_EQ(exported->messages.at("/tf"), 1u);
  EXPECT_EQ(exported->messages.at("/diagnostics"), 1u);
  EXPECT_FALSE(exported->messages.contains("/odometry/map"));
  ASSERT_EQ(exported->notes.size(), 1u);
  EXPECT_EQ(exported->notes[0].what, "1 lines are not reports");
}

// Sampled: perturb a pose as the covariance says, and look how far the vehicle moves.
TEST(McapExport, CovarianceIsThatOfTheVehiclesPosition) {
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  covariance(2, 2) = 1e-6;  // 1 mrad of heading about the origin of the frame
  covariance(3, 3) = 1e-4;
  const auto result = to_ros_covariance(covariance, {100, 0, 0});
  EXPECT_NEAR(result[0 * 6 + 0], 1e-4, 1e-12);
  EXPECT_NEAR(result[1 * 6 + 1], 1e-2, 1e-12);  // 0.1 m to the side at 100 m
  EXPECT_NEAR(result[1 * 6 + 5], 1e-4, 1e-12);  // left with a turn to the left
  EXPECT_NEAR(result[5 * 6 + 5], 1e-6, 1e-12);
}

TEST(McapExport, WhatCannotBeReadOrWrittenIsAnError) {
  const ScratchFolder folder;
  write_drive(folder / "drive");
  EXPECT_FALSE(export_mcap(folder / "none", folder / "a.mcap", {}));
  EXPECT_FALSE(export_mcap(folder / "drive", folder / "none/a.mcap", {}));
  EXPECT_FALSE(export_mcap(folder / "drive", folder / "a.mcap", {.reports = folder / "none"}));
}

}  // namespace
}  // namespace infuse::daemon
