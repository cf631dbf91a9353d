#pragma once

#include "daemon/record/recording.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <fstream>

#include "drivers/recording/drive_source.hpp"
#include "tests/daemon/pipeline/run_replay.hpp"

namespace infuse::daemon {

inline constexpr int64_t kStart = 1'700'000'000'000'000'000;

template <class Header>
inline std::vector<uint8_t> body_of(const Header& header, std::span<const uint8_t> rest = {}) {
  const auto* bytes = reinterpret_cast<const uint8_t*>(&header);
  std::vector<uint8_t> body(bytes, bytes + sizeof(header));
  body.insert(body.end(), rest.begin(), rest.end());
  return body;
}

/// A recording of a lidar, two cameras of 8 × 6 pixels, a CAN bus and a GNSS receiver.
class RecordingTest : public testing::Test {
 protected:
  RecordingTest() {
    std::filesystem::create_directories(folder_ / "drives");
    std::ofstream(folder_ / "car.dbc") << "VERSION \"\"\n";
    plan_.directory = folder_ / "drives";
    plan_.name = "d";
    plan_.cause = "requested";
    plan_.from = Stamp::from_ns(kStart);
    plan_.until = Stamp::latest();
    plan_.max_duration = from_seconds(1000);
    plan_.max_bytes = uint64_t{1} << 40;
    recording::DriveDescription& drive = plan_.description;
    drive.rig.lidars.push_back({"top", "VLP-16"});
    drive.lidars.push_back({.packets = "lidar.pcap"});
    for (const char* name : {"left", "right"}) {
      CameraMount mount;
      mount.name = name;
      mount.lidar = "top";
      mount.intrinsics.width = 8;
      mount.intrinsics.height = 6;
      mount.intrinsics.fx = mount.intrinsics.fy = 10;
      mount.stamp_delay = std::chrono::milliseconds(12);
      drive.rig.cameras.push_back(mount);
      drive.cameras.push_back({.images = std::string("camera_") + name});
    }
    drive.can.emplace();
    drive.can->log = "can.log";
    drive.can->dbc = "vehicle.dbc";
    drive.gnss = "gnss.csv";
    plan_.copies = {{folder_ / "car.dbc", "vehicle.dbc"}};
  }

  Recording begin() {
    auto recording = Recording::begin(plan_, Stamp::from_ns(kStart));
    EXPECT_TRUE(recording.has_value()) << recording.error().message();
    return *std::move(recording);
  }

  static void add(Recording& recording, int64_t offset_ns, RecordKind kind,
                  std::span<const uint8_t> body, uint32_t source = 0) {
    recording.add({{kStart + offset_ns, kind, source, body.size()}, body});
  }

  /// Adds a datagram with its number in the payload.
  static void add_datagram(Recording& recording, uint32_t number, int64_t offset_ns) {
    std::vector<uint8_t> payload(1206, static_cast<uint8_t>(number));
    std::memcpy(payload.data(), &number, sizeof(number));
    add(recording, offset_ns, RecordKind::kDatagram,
        body_of(DatagramHeader{0xC0A801C9, 2368, 2368}, payload));
  }

  static void add_image(Recording& recording, uint32_t camera, uint64_t sequence,
                        camera::RawFormat format, std::span<const uint8_t> pixels,
                        uint64_t row_bytes, int64_t offset_ns) {
    add(recording, offset_ns, RecordKind::kImage,
        body_of(ImageHeader{sequence, row_bytes, 8, 6, format}, pixels), camera);
  }

  /// Reads every event of a drive.
  std::vector<recording::DriveEvent> events(const std::string& name) {
    auto drive = recording::Drive::open(plan_.directory / name);
    EXPECT_TRUE(drive.has_value()) << drive.error().message();
    if (!drive) return {};
    auto source = recording::DriveSource::open(*drive);
    EXPECT_TRUE(source.has_value());
    std::vector<recording::DriveEvent> events;
    recording::DriveEvent event;
    while (source->next(event)) {
      if (auto* can = std::get_if<recording::CanLineEvent>(&event.content)) {
        lines_.emplace_back(can->line);
      }
      if (auto* image = std::get_if<recording::ImageEvent>(&event.content)) {
        files_.push_back(*image->path);
      }
      if (auto* packet = std::get_if<recording::DatagramEvent>(&event.content)) {
        uint32_t number = 0;
        std::memcpy(&number, packet->datagram.payload.data(), sizeof(number));
        numbers_.push_back(number);
      }
      events.push_back(event);
    }
    notes_ = source->notes();
    return events;
  }

  TemporaryFolder folder_;
  RecordingPlan plan_;
  std::vector<std::string> lines_;            // CAN lines of the last drive read
  std::vector<std::filesystem::path> files_;  // images
  std::vector<uint32_t> numbers_;             // numbers of the datagrams
  std::vector<Error> notes_;
};

}  // namespace infuse::daemon
