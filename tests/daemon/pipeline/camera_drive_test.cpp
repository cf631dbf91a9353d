// Cameras, a bus and an inertial unit beside a lidar, in a synthetic drive of a vehicle that stands
// still.

#include <gmock/gmock.h>
#include <png.h>

#include "drivers/recording/drive.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"
#include "fixtures/scene/capture.hpp"
#include "tests/daemon/pipeline/run_replay.hpp"
#include "tests/daemon/schema.hpp"

namespace infuse::daemon {
namespace {

using nlohmann::json;

constexpr int64_t kStart = 1'700'000'600'000'000'000;
constexpr int kWidth = 64, kHeight = 48;

void write_image(const std::filesystem::path& path, uint8_t grey) {
  const std::vector<uint8_t> pixels(static_cast<size_t>(kWidth) * kHeight, grey);
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = kWidth;
  image.height = kHeight;
  image.format = PNG_FORMAT_GRAY;
  ASSERT_EQ(png_image_write_to_file(&image, path.c_str(), 0, pixels.data(), 0, nullptr), 1);
}

/// Makes a drive of three seconds with `cameras` cameras at 10 Hz, an inertial unit and a bus.
void make_drive(const std::filesystem::path& folder, int cameras) {
  std::filesystem::create_directories(folder);
  fixtures::CaptureOptions capture;
  capture.model = &velodyne::lidar_model(velodyne::Model::kVlp16);
  capture.duration = from_seconds(3);
  ASSERT_TRUE(fixtures::make_capture(folder / "lidar.pcap", capture));
  recording::DriveDescription drive;
  drive.rig.lidars.push_back({.name = "top", .model = "VLP-16"});
  drive.lidars.push_back({.packets = "lidar.pcap"});
  for (int i = 0; i < cameras; ++i) {
    const std::string name = "camera" + std::to_string(i);
    CameraMount mount;
    mount.name = name;
    mount.lidar = "top";
    mount.intrinsics.width = kWidth;
    mount.intrinsics.height = kHeight;
    mount.intrinsics.fx = mount.intrinsics.fy = 40;
    mount.intrinsics.cx = 31.5;
    mount.intrinsics.cy = 23.5;
    mount.T_camera_lidar.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
    drive.rig.cameras.push_back(mount);
    drive.cameras.push_back({.images = name});
    std::filesystem::create_directories(folder / name);
    std::ofstream times(folder / name / "times.csv");
    times << "stamp_ns\n";
    for (int k = 0; k < 30; ++k) {
      times << kStart + k * 100'000'000LL + i * 7'000'000 + 3'000'000 << "\n";
      char file[16];
      std::snprintf(file, sizeof(file), "%06d.png", k);
      write_image(folder / name / file, static_cast<uint8_t>(8 * k));
    }
  }
  drive.imu = "imu.csv";
  std::ofstream imu(folder / "imu.csv");
  imu << "stamp_ns,wx,wy,wz,ax,ay,az\n";
  for (int k = 0; k < 300; ++k) imu << kStart + k * 10'000'000LL << ",0,0,0,0,0,9.81\n";
  drive.can = recording::CanFiles{.log = "can.log", .dbc = "v.dbc"};
  drive.can->signals.push_back({.quantity = "wheel_speed_rear_left", .signal = "WHEELS.LEFT"});
  drive.can->signals.push_back({.quantity = "wheel_speed_rear_right", .signal = "WHEELS.RIGHT"});
  std::ofstream(folder / "v.dbc") << "BO_ 256 WHEELS: 4 CAR\n"
                                     " SG_ LEFT : 0|16@1+ (0.01,0) [0|0] \"m/s\" X\n"
                                     " SG_ RIGHT : 16|16@1+ (0.01,0) [0|0] \"m/s\" X\n";
  std::ofstream bus(folder / "can.log");
  for (int k = 0; k < 150; ++k) {
    char line[64];
    std::snprintf(line, sizeof(line), "(%d.%06d) can0 100#00000000\n", 1'700'000'600 + k / 50,
                  k % 50 * 20'000 + 5'000);
    bus << line;
  }
  bus.close();
  ASSERT_TRUE(recording::write_drive_toml(folder, drive));
}

TEST(CameraDrive, ImagesOfSeveralCamerasAreMatchedToSweepsInOneOrderAtEveryRate) {
  const TemporaryFolder folder;
  ASSERT_NO_FATAL_FAILURE(make_drive(folder / "drive", 3));
  const auto fast = run_replay(folder / "drive");
  ASSERT_TRUE(fast) << fast.error().message();
  std::vector<int> frames(3);
  int deskewed = 0, sweeps = 0;
  for (const std::string& line : fast->lines()) {
    ASSERT_TRUE(is_valid_message(line));
    const json report = json::parse(line);
    if (report["class"] == "SWEEP") {
      ++sweeps;
      deskewed += report["deskewed"].get<bool>() ? 1 : 0;
      if (report["deskewed"].get<bool>()) {
        EXPECT_LT(report["travelled"].get<double>(), 0.01);
      }
    }
    if (report["class"] != "FRAME") continue;
    const auto camera = static_cast<size_t>(report["device"].get<std::string>().back() - '0');
    EXPECT_EQ(report["sequence"].get<int>(), frames[camera]);
    EXPECT_NEAR(report["mean_brightness"].get<double>(), 8.0 * frames[camera] / 255, 1e-3);
    ++frames[camera];
  }
  EXPECT_EQ(frames, std::vector<int>(3, 30));
  EXPECT_GE(deskewed, sweeps - 2);
  EXPECT_EQ(run_replay(folder / "drive", {.rate = 8})->reports, fast->reports);
}

TEST(CameraDrive, CanBeStoppedWhileImagesAreDecoded) {
  const TemporaryFolder folder;
  ASSERT_NO_FATAL_FAILURE(make_drive(folder / "drive", 2));
  const auto result =
      run_replay(folder / "drive", {.rate = 1, .stop_after = std::chrono::milliseconds(300)});
  ASSERT_TRUE(result);
  EXPECT_TRUE(result->totals.ended);
  EXPECT_LT(result->totals.counters.lidars.at(0).packets, 3 * 754U);
}

}  // namespace
}  // namespace infuse::daemon
