#include "daemon/record/recording.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <csignal>
#include <fstream>
#include <random>

#include "daemon/record/recorder.hpp"
#include "drivers/camera/image_decoder.hpp"
#include "drivers/recording/drive_source.hpp"
#include "tests/daemon/pipeline/run_replay.hpp"

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

constexpr int64_t kStart = 1'700'000'000'000'000'000;

template <class Header>
std::vector<uint8_t> body_of(const Header& header, std::span<const uint8_t> rest = {}) {
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

TEST_F(RecordingTest, EndsAtItsLimits) {
  plan_.max_duration = std::chrono::milliseconds(10);
  Recording by_time = begin();
  for (uint32_t i = 0; i < 20; ++i) add_datagram(by_time, i, i * 1'000'000);
  EXPECT_TRUE(by_time.report().ended);
  EXPECT_FALSE(by_time.report().failed);
  EXPECT_THAT(by_time.report().reason, HasSubstr("duration"));
  events("d");
  EXPECT_EQ(numbers_.size(), 11U);

  plan_.name = "e";
  plan_.max_duration = from_seconds(100);
  plan_.max_bytes = 100'000;
  Recording by_size = begin();
  for (uint32_t i = 0; i < 200; ++i) add_datagram(by_size, i, i * 1'000);
  EXPECT_TRUE(by_size.report().ended);
  EXPECT_THAT(by_size.report().reason, HasSubstr("size"));
  EXPECT_LT(by_size.report().bytes, 102'000U);
  EXPECT_EQ(std::filesystem::file_size(plan_.directory / "e" / "lidar.pcap") +
                std::filesystem::file_size(plan_.directory / "e" / "vehicle.dbc") +
                std::filesystem::file_size(plan_.directory / "e" / "gnss.csv") +
                std::filesystem::file_size(plan_.directory / "e" / "camera_left/times.csv") +
                std::filesystem::file_size(plan_.directory / "e" / "camera_right/times.csv"),
            by_size.report().bytes);
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

TEST_F(RecordingTest, NeverOverwritesAnExistingDrive) {
  Recording first = begin();
  const auto second = Recording::begin(plan_, Stamp::from_ns(kStart));
  ASSERT_FALSE(second.has_value());
  EXPECT_THAT(second.error().message(), HasSubstr("already exists"));
}

TEST_F(RecordingTest, KeepsTheMinimumFreeSpace) {
  plan_.min_free_bytes = uint64_t{1} << 62;
  const auto refused = Recording::begin(plan_, Stamp::from_ns(kStart));
  ASSERT_FALSE(refused.has_value());
  EXPECT_THAT(refused.error().message(), HasSubstr("required"));
  EXPECT_FALSE(std::filesystem::exists(plan_.directory / "d"));
}

/// Limits the file size of this process, to simulate a disk that fills in the middle of a record.
class FileLimit {
 public:
  explicit FileLimit(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileLimit() { setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

TEST_F(RecordingTest, AFullDiskEndsTheRecordingAndLeavesAValidDrive) {
  Recording recording = begin();
  {
    const FileLimit limit(50'123);
    for (uint32_t i = 0; i < 1000 && !recording.report().ended; ++i) {
      add_datagram(recording, i, i * 1'000);
      if (i % 7 == 0) recording.flush_and_check(Stamp::from_ns(kStart), 0, true);
    }
  }
  EXPECT_TRUE(recording.report().ended);
  EXPECT_TRUE(recording.report().failed);
  EXPECT_THAT(recording.report().reason, HasSubstr("is the disk full?"));
  events("d");
  EXPECT_TRUE(notes_.empty()) << notes_[0].message();
  EXPECT_GT(numbers_.size(), 25U);  // 39 fit
  for (uint32_t i = 0; i < numbers_.size(); ++i) EXPECT_EQ(numbers_[i], i);
}

TEST_F(RecordingTest, AFullDiskLeavesNoPartialCanLine) {
  Recording recording = begin();
  {
    const FileLimit limit(3'333);
    vehicle::CanFrame frame;
    frame.length = 8;
    for (int i = 0; i < 1000 && !recording.report().ended; ++i) {
      frame.stamp = Stamp::from_ns(kStart + i * 1'000);
      add(recording, i * 1'000, RecordKind::kCanFrame, body_of(frame));
      if (i % 5 == 4) recording.flush_and_check(Stamp::from_ns(kStart), 0, true);
    }
  }
  EXPECT_TRUE(recording.report().failed);
  events("d");
  EXPECT_GT(lines_.size(), 60U);
  for (const std::string& line : lines_) EXPECT_EQ(line.size(), lines_[0].size());
}

// Killed at any moment, what was handed to the system is a drive.
TEST_F(RecordingTest, ADriveIsValidWheneverTheProcessIsKilled) {
  std::mt19937 random(11);
  const std::vector<uint8_t> grey(48, 77);
  for (int round = 0; round < 12; ++round) {
    plan_.name = "k" + std::to_string(round);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      auto recording = Recording::begin(plan_, Stamp::from_ns(kStart));
      for (uint32_t i = 0;; ++i) {
        add_datagram(*recording, i, i * 1'000);
        add_image(*recording, 0, i, camera::RawFormat::kGrey, grey, 8, i * 1'000);
        if (i % 16 == 0) recording->flush_and_check(Stamp::from_ns(kStart), 0, true);
      }
    }
    while (!std::filesystem::exists(plan_.directory / plan_.name / "camera_left/000001.png")) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 5000));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    numbers_.clear();
    files_.clear();
    const auto all = events(plan_.name);
    for (uint32_t i = 0; i < numbers_.size(); ++i) EXPECT_EQ(numbers_[i], i);
    for (const auto& file : files_) EXPECT_GT(std::filesystem::file_size(file), 60U);
    EXPECT_GT(all.size(), 0U);
  }
}

TEST(Recorder, KeepsTheNewestAlertRecordings) {
  TemporaryFolder folder;
  for (const char* name :
       {"alert-20260101-a", "alert-20260102-b", "alert-20260102-b.2", "alert-20260103-c", "mine"}) {
    std::filesystem::create_directories(folder / name / "camera_0");
  }
  remove_old_alerts(folder / "", 2, "");
  EXPECT_FALSE(std::filesystem::exists(folder / "alert-20260101-a"));
  EXPECT_TRUE(std::filesystem::exists(folder / "alert-20260102-b.2"));
  EXPECT_TRUE(std::filesystem::exists(folder / "alert-20260103-c"));
  EXPECT_TRUE(std::filesystem::exists(folder / "mine"));
  remove_old_alerts(folder / "", 1, "");
  EXPECT_FALSE(std::filesystem::exists(folder / "alert-20260102-b"));
  EXPECT_FALSE(std::filesystem::exists(folder / "alert-20260102-b.2"));
}

}  // namespace
}  // namespace infuse::daemon
