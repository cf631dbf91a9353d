#include "daemon/ros/mcap_recording.hpp"

#include <gtest/gtest.h>

#include "drivers/mcap/mcap_reader.hpp"
#include "drivers/ros/messages.hpp"
#include "drivers/text/text_file.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

MessageSetup one_lidar_setup(bool live) {
  MessageSetup setup{.live = live};
  setup.rig.lidars = {LidarMount{.name = "top"}};
  setup.packet_makers = {&velodyne::maker()};
  setup.packet_metadata = {""};
  return setup;
}

Stamp at_ms(int64_t ms) { return Stamp::from_ns(1'700'000'000'000'000'000 + ms * 1'000'000); }

void add_imu(McapRecording& recording, int64_t ms) {
  recording.write("/vehicle/imu", at_ms(ms), ros::Imu{});
}

std::vector<int64_t> times_in(const std::filesystem::path& path) {
  const std::string bytes = text::read_text(path, 1 << 26).value_or("");
  auto reader = mcap::McapReader::open(
      {reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()}, "test");
  std::vector<int64_t> times;
  if (!reader) return times;
  for (mcap::Message message; reader->next(message);) times.push_back(message.log_time.ns());
  return times;
}

// As a killed process leaves the file: what the kernel has of it before it is closed.
TEST(McapRecording, AFileThatIsNotClosedIsReadableToItsLastSecond) {
  const ScratchFolder folder;
  const auto recording = McapRecording::create(folder / "a.mcap", one_lidar_setup(true));
  ASSERT_TRUE(recording) << recording.error().message();
  for (int64_t ms = 0; ms < 5'000; ms += 10) {
    add_imu(**recording, ms);
    const auto times = times_in(folder / "a.mcap");
    if (ms < 2'000) continue;
    ASSERT_FALSE(times.empty());
    EXPECT_LE(at_ms(ms).ns() - times.back(), 1'010'000'000);
  }
  ASSERT_TRUE((*recording)->close());
  EXPECT_EQ(times_in(folder / "a.mcap").size(), 500u);
}

TEST(McapRecording, OfAReplayASecondIsWrittenInOrderWhenAllLanesHavePassedIt) {
  const ScratchFolder folder;
  const auto created = McapRecording::create(folder / "a.mcap", one_lidar_setup(false));
  ASSERT_TRUE(created);
  McapRecording& recording = **created;
  using Lane = MessageSink::Lane;
  // One lane is a second ahead of the others.
  recording.begin_lane(Lane::kSensors);
  add_imu(recording, 300);
  recording.end_second();
  add_imu(recording, 1'300);
  recording.begin_lane(Lane::kReports);
  recording.write("/tf", at_ms(100), ros::TfMessage{});
  recording.write("/tf", at_ms(300), ros::TfMessage{});
  recording.end_second();
  recording.begin_lane(Lane::kSweeps);
  recording.write("/lidar/top/points", at_ms(200), ros::PointCloud2{});
  recording.end_second();
  recording.begin_lane(Lane::kSensors);
  add_imu(recording, 1'400);
  ASSERT_TRUE(recording.close());
  const std::vector<int64_t> expected = {at_ms(100).ns(), at_ms(200).ns(),   at_ms(300).ns(),
                                         at_ms(300).ns(), at_ms(1'300).ns(), at_ms(1'400).ns()};
  EXPECT_EQ(times_in(folder / "a.mcap"), expected);
}

TEST(McapRecording, MeasuredCloudsOfALidarWithPacketsAreNotWrittenTwice) {
  const ScratchFolder folder;
  const auto recording = McapRecording::create(folder / "a.mcap", one_lidar_setup(true));
  ASSERT_TRUE(recording);
  EXPECT_FALSE((*recording)->wants("/lidar/top/points_raw"));
  EXPECT_TRUE((*recording)->wants("/lidar/top/packets"));
  EXPECT_TRUE((*recording)->wants("/lidar/other/points_raw"));
}

TEST(McapRecording, AFullDiskEndsTheFileAndNothingElse) {
  const auto recording = McapRecording::create("/dev/full", one_lidar_setup(true));
  if (!recording) GTEST_SKIP() << recording.error().message();
  for (int64_t ms = 0; ms < 5'000; ms += 10) add_imu(**recording, ms);
  EXPECT_FALSE((*recording)->wants("/vehicle/imu"));
  EXPECT_FALSE((*recording)->close());
}

}  // namespace
}  // namespace infuse::daemon
