#include "daemon/ros/message_stream.hpp"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <condition_variable>

#include "daemon/pipeline/replay.hpp"
#include "daemon/ros/mcap_recording.hpp"
#include "daemon/setup/drive_setup.hpp"
#include "drivers/mcap/mcap_reader.hpp"
#include "drivers/recording/imu_csv.hpp"
#include "drivers/recording/mapped_file.hpp"
#include "drivers/recording/speed_csv.hpp"
#include "drivers/text/text_file.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"
#include "fixtures/scene/capture.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

namespace fs = std::filesystem;

/// A drive of 2.2 s: packets of a lidar, a speed and an inertial unit.
void make_drive(const fs::path& folder) {
  fs::create_directories(folder);
  ASSERT_TRUE(fixtures::make_capture(folder / "top.pcap",
                                     {.model = &velodyne::lidar_model(velodyne::Model::kVlp16),
                                      .duration = Duration{2'200'000'000}}));
  recording::DriveDescription drive;
  LidarMount lidar{.name = "top", .model = "VLP-16"};
  lidar.T_vehicle_lidar.translation() = Eigen::Vector3d(0.5, 0, 1.8);
  drive.rig.lidars = {lidar};
  drive.lidars.emplace_back().packets = "top.pcap";
  drive.speed = "speed.csv";
  drive.imu = "imu.csv";
  std::vector<WheelOdometry> speeds;
  std::vector<ImuSample> imu;
  for (int k = 0; k <= 220; ++k) {
    WheelOdometry speed;
    speed.stamp = Stamp::from_ns(1'700'000'600'000'000'000 + k * 10'000'000LL);
    speed.speed = 5.5;
    speeds.push_back(speed);
    ImuSample sample;
    sample.stamp = speed.stamp;
    sample.angular_velocity = {0, 0, 0.1};
    sample.linear_acceleration = {0, 0, 9.81};
    imu.push_back(sample);
  }
  ASSERT_TRUE(recording::write_speed_csv(folder / "speed.csv", speeds));
  ASSERT_TRUE(recording::write_imu_csv(folder / "imu.csv", imu));
  ASSERT_TRUE(recording::write_drive_toml(folder, drive));
}

/// Replays a drive with a stream to `sinks`, as `infused` does.
void replay_into(const fs::path& drive,
                 const std::function<MessageSink*(const MessageSetup&)>& open,
                 const fs::path& reports = {}) {
  auto setup = open_drive(drive, {}, {});
  ASSERT_TRUE(setup) << setup.error().message();
  boost::asio::io_context io(1);
  Server server(io, {}, "0", "0123456789abcdef");
  std::optional<ReportsFile> file;
  if (!reports.empty()) file = *ReportsFile::create(reports);
  const MessageSetup messages = message_setup(*setup);
  MessageStream stream(messages, {open(messages)});
  PipelineOptions options;
  options.tap = &stream;
  Replay replay(io, *std::move(setup), {std::nullopt, options}, server, file ? &*file : nullptr,
                [&] {
                  stream.finish();
                  server.finish(std::chrono::seconds(5));
                });
  replay.publisher().add_line_listener(
      [&](ReportClass report_class, const std::string&, const std::string& line) {
        stream.add_report(report_class, line);
      });
  stream.start(replay.pipeline().items());
  replay.start();
  io.run();
  if (file) {
    ASSERT_TRUE(file->close());
  }
  EXPECT_EQ(stream.lost(), 0u);
  std::vector<Error> notes;
  stream.append_notes(notes);
  EXPECT_TRUE(notes.empty());
}

std::string record(const fs::path& drive, const fs::path& path, const fs::path& reports = {}) {
  std::unique_ptr<McapRecording> recording;
  replay_into(
      drive,
      [&](const MessageSetup& setup) {
        recording = *McapRecording::create(path, setup);
        return recording.get();
      },
      reports);
  EXPECT_TRUE(recording->close());
  return text::read_text(path, size_t{1} << 30).value_or("");
}

struct TopicMessage {
  int64_t log_time = 0;
  std::string data;
  bool operator==(const TopicMessage&) const = default;
};

std::map<std::string, std::vector<TopicMessage>> read_messages(const std::string& bytes) {
  std::map<std::string, std::vector<TopicMessage>> topics;
  auto reader = mcap::McapReader::open(
      {reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()}, "test");
  EXPECT_TRUE(reader);
  for (mcap::Message message; reader && reader->next(message);) {
    topics[message.channel->topic].push_back(
        {message.log_time.ns(), std::string(message.data.begin(), message.data.end())});
  }
  return topics;
}

TEST(MessageStream, AReplayWritesTheSameFileEveryTimeAndTheSameReportsAsWithout) {
  const ScratchFolder folder;
  make_drive(folder / "drive");
  const std::string first = record(folder / "drive", folder / "1.mcap", folder / "with");
  const std::string second = record(folder / "drive", folder / "2.mcap");
  EXPECT_EQ(first, second);
  class Nothing : public MessageSink {
    bool wants(const std::string&) const override { return false; }
    void add(const std::string& topic, const char*, Stamp, bool,
             std::span<const uint8_t>) override {
      ADD_FAILURE() << topic << " is not wanted";
    }
  } nothing;
  replay_into(
      folder / "drive", [&](const MessageSetup&) { return &nothing; }, folder / "without");
  const auto with = text::read_text(folder / "with", 1 << 26);
  ASSERT_TRUE(with);
  EXPECT_GT(with->size(), 10'000u);
  EXPECT_EQ(*with, text::read_text(folder / "without", 1 << 26).value_or(""));
}

TEST(MessageStream, EveryKindOfMessageIsThereInOrderOfTime) {
  const ScratchFolder folder;
  make_drive(folder / "drive");
  const auto topics = read_messages(record(folder / "drive", folder / "a.mcap"));
  const auto count = [&](const std::string& topic) {
    const auto found = topics.find(topic);
    return found == topics.end() ? 0 : found->second.size();
  };
  EXPECT_EQ(count("/tf_static"), 1u);
  EXPECT_EQ(count("/vehicle/twist"), 221u);
  EXPECT_EQ(count("/vehicle/imu"), 221u);
  EXPECT_EQ(count("/lidar/top/points_raw"), 0u);  // its packets are there
  EXPECT_GE(count("/lidar/top/packets"), 22u);
  EXPECT_GE(count("/lidar/top/points"), 18u);
  EXPECT_EQ(count("/odometry/odom"), count("/tf"));
  EXPECT_GE(count("/odometry/odom"), count("/lidar/top/points"));
  EXPECT_GE(count("/diagnostics"), 3u);  // HEALTH, each second
  for (const auto& [topic, messages] : topics) {
    for (size_t k = 1; k < messages.size(); ++k)
      EXPECT_LE(messages[k - 1].log_time, messages[k].log_time) << topic;
  }
}

/// A sink that is held up.
class SlowSink : public MessageSink {
 public:
  bool wants(const std::string&) const override { return true; }
  void add(const std::string&, const char*, Stamp, bool, std::span<const uint8_t>) override {
    std::unique_lock lock(mutex_);
    released_.wait(lock, [this] { return is_released_; });
    ++messages_;
  }
  void release() {
    const std::lock_guard lock(mutex_);
    is_released_ = true;
    released_.notify_all();
  }
  size_t messages() const { return messages_; }

 private:
  std::mutex mutex_;
  std::condition_variable released_;
  bool is_released_ = false;
  size_t messages_ = 0;
};

MessageSetup live_setup() {
  MessageSetup setup{.live = true};
  setup.rig.lidars = {LidarMount{.name = "top"}};
  setup.packet_makers = {&velodyne::maker()};
  setup.packet_metadata = {""};
  return setup;
}

TEST(MessageStream, LiveAnythingIsDroppedRatherThanWaitedFor) {
  SlowSink sink;
  SlotRing<StreamItem> ring(8, [] { return StreamItem(); });
  MessageStream stream(live_setup(), {&sink});
  stream.start(ring);
  Sweep sweep;
  sweep.resize(10);
  std::ranges::fill(sweep.reflectivity, 0.5F);
  std::ranges::fill(sweep.ring, uint16_t{1});
  std::ranges::fill(sweep.column, uint16_t{1});
  std::ranges::fill(sweep.time_offset_ns, 0);
  std::ranges::fill(sweep.range, 1.0F);
  std::ranges::fill(sweep.return_kind, ReturnKind{});
  std::ranges::fill(sweep.x, 1.0F);
  std::ranges::fill(sweep.y, 1.0F);
  std::ranges::fill(sweep.z, 1.0F);
  motion::DeskewedSweep deskewed;
  deskewed.x.assign(10, 1.0F);
  deskewed.y.assign(10, 1.0F);
  deskewed.z.assign(10, 1.0F);
  deskewed.reference = Stamp::from_ns(1'000'000'000);
  constexpr size_t kEach = 5000;        // more than all that may wait
  for (size_t k = 0; k < kEach; ++k) {  // nobody reads: this would hang if anything waited
    StreamItem& item = ring.slot();
    item.kind = StreamItem::Kind::kSamples;
    item.stamp = Stamp::from_ns(1'000'000'000);
    item.samples = {ImuSample{}};
    item.from_bus = {0};
    ring.publish();
    stream.add_sweep({LidarIndex(0), sweep, deskewed});
    stream.add_report(ReportClass::kPose, "{}");
  }
  EXPECT_GT(stream.stats().lost, 0u);
  sink.release();
  stream.finish();
  // All that was not lost has come: each sample a message, each sweep one; those reports are none.
  const uint64_t all = 2 * kEach + kEach;
  EXPECT_LT(sink.messages(), 2 * kEach);
  EXPECT_GE(stream.lost() + sink.messages(), 2 * kEach);
  EXPECT_LE(stream.lost() + sink.messages(), all);
}

TEST(MessageStream, LiveItSleepsWhileNobodyWantsAnything) {
  class Counting : public MessageSink {
   public:
    bool wants(const std::string&) const override {
      ++asked;
      return true;
    }
    void add(const std::string&, const char*, Stamp, bool, std::span<const uint8_t>) override {
      ++added;
    }
    mutable std::atomic<int> asked = 0, added = 0;
  } sink;
  std::atomic<bool> wanted = false;
  SlotRing<StreamItem> ring(8, [] { return StreamItem(); });
  MessageStream stream(live_setup(), {&sink}, [&] { return wanted.load(); });
  stream.start(ring);
  const auto publish = [&] {
    StreamItem& item = ring.slot();
    item.kind = StreamItem::Kind::kSamples;
    item.stamp = Stamp::from_ns(1'000'000'000);
    item.samples = {ImuSample{}};
    item.from_bus = {0};
    ring.publish();
  };
  for (int k = 0; k < 100; ++k) publish();
  EXPECT_EQ(sink.added, 0);
  wanted = true;
  stream.wake();
  while (sink.added == 0) {
    publish();
    std::this_thread::yield();
  }
  stream.finish();
}

}  // namespace
}  // namespace infuse::daemon
