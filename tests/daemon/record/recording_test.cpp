#include "daemon/record/recording.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <fstream>
#include <random>

#include "daemon/record/recorder.hpp"
#include "drivers/camera/image_decoder.hpp"
#include "drivers/recording/drive_source.hpp"
#include "tests/daemon/pipeline/run_replay.hpp"
#include "tests/daemon/record/recording_fixture.hpp"

namespace infuse::daemon {
namespace {

TEST_F(RecordingTest, AllKindsOfRecordsReadBackUnchanged) {
  Recording recording = begin();
  add_datagram(recording, 7, 1'000'001);
  vehicle::CanFrame frame;
  frame.set_interface("can1");
  frame.stamp = Stamp::from_ns(kStart + 2'000'000);
  frame.id = 0x123;
  frame.length = 2;
  frame.data = {0xAB, 0xCD};
  add(recording, 2'000'000, RecordKind::kCanFrame, body_of(frame));
  GnssFix fix;
  fix.stamp = Stamp::from_ns(kStart + 3'000'000);
  fix.latitude = 0.9;
  fix.longitude = 0.2;
  fix.valid = true;
  add(recording, 3'000'000, RecordKind::kGnssFix, body_of(fix));
  const std::vector<uint8_t> grey(48, 77);
  add_image(recording, 1, 500, camera::RawFormat::kGrey, grey, 8, 4'000'000);
  add_image(recording, 1, 502, camera::RawFormat::kGrey, grey, 8, 5'000'000);
  recording.end("");
  const RecordReport& report = recording.report();
  EXPECT_TRUE(report.ended);
  EXPECT_FALSE(report.failed) << report.reason;
  EXPECT_EQ(report.datagrams, 1U);
  EXPECT_EQ(report.frames, 1U);
  EXPECT_EQ(report.fixes, 1U);
  EXPECT_EQ(report.images, 2U);
  EXPECT_EQ(report.duration, std::chrono::nanoseconds(3'999'999));

  const auto all = events("d");
  ASSERT_EQ(all.size(), 5U);
  const auto& datagram = std::get<recording::DatagramEvent>(all[0].content);
  EXPECT_EQ(all[0].stamp.ns(), kStart + 1'000'001);
  EXPECT_EQ(datagram.lidar, 0U);
  EXPECT_EQ(datagram.datagram.sender, 0xC0A801C9U);
  EXPECT_EQ(numbers_, std::vector<uint32_t>{7});
  EXPECT_EQ(lines_, std::vector<std::string>{"(1700000000.002000) can1 123#ABCD"});
  EXPECT_NEAR(std::get<GnssFix>(all[2].content).latitude, 0.9, 1e-15);
  // Stamps are those of the exposures, independent of the camera's delay; one frame was lost.
  EXPECT_EQ(all[3].stamp.ns(), kStart + 4'000'000);
  EXPECT_EQ(std::get<recording::ImageEvent>(all[3].content).sequence, 0U);
  EXPECT_EQ(std::get<recording::ImageEvent>(all[4].content).sequence, 2U);
  EXPECT_TRUE(std::filesystem::exists(plan_.directory / "d" / "vehicle.dbc"));
}

// What a replay decodes is what the pipeline unpacks.
TEST_F(RecordingTest, ImagesOfEveryFormatDecodeAsInThePipeline) {
  std::mt19937 random(3);
  std::vector<uint8_t> bytes(8 * 6 * 3 + 64);
  for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random());
  using camera::RawFormat;
  for (const RawFormat format :
       {RawFormat::kGrey, RawFormat::kYuyv, RawFormat::kUyvy, RawFormat::kRgb24, RawFormat::kBgr24,
        RawFormat::kBayerRggb, RawFormat::kBayerBggr, RawFormat::kBayerGbrg,
        RawFormat::kBayerGrbg}) {
    SCOPED_TRACE(camera::name_of(format));
    plan_.name = camera::name_of(format);
    Recording recording = begin();
    const size_t row = camera::packed_row_bytes(format, 8) + 3;  // padded
    add_image(recording, 0, 1, format, std::span(bytes).first(row * 6), row, 1000);
    recording.end("");
    files_.clear();
    events(plan_.name);
    ASSERT_EQ(files_.size(), 1U);
    auto drive = recording::Drive::open(plan_.directory / plan_.name);
    const recording::CameraFiles& reading = drive->description.cameras[0];
    std::ifstream stream(files_[0], std::ios::binary);
    const std::string file((std::istreambuf_iterator<char>(stream)), {});
    CameraFrame replayed, live;
    const std::span<const uint8_t> encoded(reinterpret_cast<const uint8_t*>(file.data()),
                                           file.size());
    ASSERT_TRUE(
        camera::decode_image(encoded, {.bayer = reading.mosaic, .grey = reading.grey}, replayed));
    ASSERT_TRUE(camera::unpack({format, 8, 6, row, std::span(bytes).first(row * 6)}, true, live));
    EXPECT_EQ(replayed.format, live.format);
    EXPECT_EQ(replayed.pixels, live.pixels);
  }
}

TEST_F(RecordingTest, MotionJpegIsStoredUnchanged) {
  Recording recording = begin();
  const std::vector<uint8_t> jpeg = {0xFF, 0xD8, 1, 2, 3, 0xFF, 0xD9};
  add_image(recording, 0, 1, camera::RawFormat::kMjpeg, jpeg, 0, 1000);
  recording.end("");
  events("d");
  ASSERT_EQ(files_.size(), 1U);
  EXPECT_EQ(files_[0].extension(), ".jpg");
  std::ifstream stream(files_[0], std::ios::binary);
  const std::string file((std::istreambuf_iterator<char>(stream)), {});
  EXPECT_EQ(file, std::string(jpeg.begin(), jpeg.end()));
  EXPECT_TRUE(recording::Drive::open(plan_.directory / "d")->description.cameras[0].grey);
}

TEST_F(RecordingTest, IgnoresRecordsOutsideItsTimeSpan) {
  plan_.until = Stamp::from_ns(kStart + 5'000);
  Recording recording = begin();
  for (int64_t offset = -3; offset < 10; ++offset) {
    add_datagram(recording, static_cast<uint32_t>(offset + 10), offset * 1'000);
  }
  recording.flush_and_check(Stamp::from_ns(kStart) + from_seconds(3), 4, true);
  EXPECT_TRUE(recording.report().ended);
  EXPECT_EQ(recording.report().lost, 4U);
  EXPECT_EQ(recording.report().reason, "");
  events("d");
  EXPECT_EQ(numbers_, (std::vector<uint32_t>{10, 11, 12, 13, 14, 15}));
}

TEST_F(RecordingTest, ALateWriterStillGetsAllItsRecords) {
  plan_.until = Stamp::from_ns(kStart + 5'000);
  Recording recording = begin();
  add_datagram(recording, 1, 1'000);
  recording.flush_and_check(Stamp::from_ns(kStart) + from_seconds(3), 0, false);
  EXPECT_FALSE(recording.report().ended);
  add_datagram(recording, 2, 2'000);
  // This record is late enough that no earlier one can be missing.
  add_datagram(recording, 3, 2'000'000'000);
  EXPECT_TRUE(recording.report().ended);
  EXPECT_EQ(recording.report().reason, "");
  events("d");
  EXPECT_EQ(numbers_, (std::vector<uint32_t>{1, 2}));
}

TEST_F(RecordingTest, SplittingLosesNoRecord) {
  plan_.split_bytes = 30'000;
  Recording recording = begin();
  for (uint32_t i = 0; i < 100; ++i) add_datagram(recording, i, i * 1'000);
  recording.end("");
  const uint32_t drives = recording.report().drives;
  EXPECT_GT(drives, 3U);
  events("d");
  for (uint32_t i = 2; i <= drives; ++i) events("d." + std::to_string(i));
  ASSERT_EQ(numbers_.size(), 100U);
  for (uint32_t i = 0; i < 100; ++i) EXPECT_EQ(numbers_[i], i);

  plan_.name = "t";
  plan_.split_bytes = 0;
  plan_.split_duration = std::chrono::milliseconds(1);
  Recording by_time = begin();
  for (uint32_t i = 0; i < 30; ++i) add_datagram(by_time, i, i * 100'000);
  EXPECT_EQ(by_time.report().drives, 3U);
}

}  // namespace
}  // namespace infuse::daemon
