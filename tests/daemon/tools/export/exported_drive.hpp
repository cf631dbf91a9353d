#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "drivers/camera/png_encoder.hpp"
#include "drivers/gnss/gnss_csv.hpp"
#include "drivers/recording/imu_csv.hpp"
#include "drivers/recording/speed_csv.hpp"
#include "drivers/recording/sweep_export.hpp"
#include "drivers/recording/times_csv.hpp"
#include "drivers/text/text_file.hpp"
#include "fixtures/scene/capture.hpp"
#include "tests/real_data.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {

namespace fs = std::filesystem;

inline constexpr Duration kHalfSecond{500'000'000};
inline constexpr int64_t kStart = 1'700'000'600'000'000'000;  // of a fixture's capture

inline Eigen::Isometry3d make_motion(double angle) {
  return Eigen::Translation3d(1.25, -angle, 1.8) *
         Eigen::AngleAxisd(angle, Eigen::Vector3d(1, 2, -1).normalized());
}

/// A sweep as another lidar's driver delivers it: 16 rings, 60 columns, times by column.
inline Sweep make_sweep(int64_t stamp) {
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
inline void write_drive(const fs::path& drive) {
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

}  // namespace infuse::daemon
