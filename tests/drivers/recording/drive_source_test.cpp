#include "drivers/recording/drive_source.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/drivers/recording/capture_bytes.hpp"
#include "tests/real_data.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::recording {
namespace {

using namespace testing;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string to_text(const Bytes& bytes) { return {bytes.begin(), bytes.end()}; }

// A stream with given stamps; each event is an IMU sample that contains the stream's number.
class ListStream : public EventStream {
 public:
  ListStream(double name, std::vector<int64_t> stamps) : name_(name), stamps_(std::move(stamps)) {}
  bool next(DriveEvent& event) override {
    if (next_index_ == stamps_.size()) return false;
    event.stamp = Stamp::from_ns(stamps_[next_index_++]);
    event.content = ImuSample{event.stamp, {name_, 0, 0}, {}};
    return true;
  }
  void append_notes(std::vector<Error>& notes) const override {
    notes.push_back({"stream " + std::to_string(static_cast<int>(name_)), {}, {}});
  }

 private:
  double name_;
  std::vector<int64_t> stamps_;
  size_t next_index_ = 0;
};

TEST(DriveSource, MergesLikeAStableSort) {
  std::mt19937 random(5);
  for (int round = 0; round < 100; ++round) {
    DriveSource source;
    std::vector<std::pair<int64_t, int>> expected;
    for (int stream = 0; stream < 5; ++stream) {
      std::vector<int64_t> stamps(random() % 30);
      for (int64_t& stamp : stamps) stamp = static_cast<int64_t>(random() % 40);
      std::sort(stamps.begin(), stamps.end());
      for (const int64_t stamp : stamps) expected.emplace_back(stamp, stream);
      source.add(std::make_unique<ListStream>(stream, stamps));
    }
    std::stable_sort(expected.begin(), expected.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    DriveEvent event;
    for (const auto& [stamp, stream] : expected) {
      ASSERT_TRUE(source.next(event));
      ASSERT_EQ(event.stamp.ns(), stamp);
      ASSERT_EQ(std::get<ImuSample>(event.content).angular_velocity[0], stream);
    }
    EXPECT_FALSE(source.next(event));
    EXPECT_FALSE(source.next(event));
    EXPECT_EQ(source.out_of_order_count(), 0u);
    EXPECT_EQ(source.notes().size(), 5u);
  }
}

TEST(DriveSource, ClockStepsBackwardLoseNoEvents) {
  DriveSource source;
  source.add(std::make_unique<ListStream>(0, std::vector<int64_t>{10, 20, 5, 30}));
  source.add(std::make_unique<ListStream>(1, std::vector<int64_t>{15, 25}));
  std::vector<int64_t> stamps;
  DriveEvent event;
  while (source.next(event)) stamps.push_back(event.stamp.ns());
  EXPECT_THAT(stamps, ElementsAre(10, 15, 20, 5, 25, 30));
  EXPECT_EQ(source.out_of_order_count(), 1u);
}

// A drive with two lidars in one capture, sweeps, images, CAN, IMU and GNSS, interleaved.
class WholeDrive : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto frame = [](uint32_t sender, uint16_t port) {
      return ethernet(ipv4(udp(make_payload(12), port), {.sender = sender}));
    };
    folder_.write("lidar.pcap", to_text(pcap(kEthernet, {{0, 10, frame(1, 2368)},
                                                         {0, 60, frame(2, 2368)},
                                                         {0, 70, frame(2, 8308)},
                                                         {0, 80, frame(3, 2368)},
                                                         {0, 90, frame(1, 9999)}})) +
                                    "cut off");
    folder_.write("sweeps/times.csv", "stamp_ns,end_ns\n15,20\n60,65\n70,75\n");
    folder_.write("sweeps/000000.bin", std::string(32, '\0'));
    folder_.write("sweeps/000001.bin", "no sweep");
    folder_.write("sweeps/000002.bin", std::string(16, '\0'));
    folder_.write("left/times.csv", "stamp_ns\n1000030\n1000066\n");
    folder_.write("left/000000.png", "");
    folder_.write("left/000001.jpg", "");
    folder_.write("can.log",
                  "(0.000000040) can0 123#00\nrubbish\n(0.000000050) can0 124#\n(x) can0 1#\n");
    folder_.write("vehicle.dbc", "");
    folder_.write("imu.csv", "stamp_ns,wx,wy,wz,ax,ay,az\n45,1,2,3,4,5,6\n46,1,2,,4,5,6\n");
    folder_.write("gnss.csv", "stamp_ns,latitude_deg,longitude_deg,valid\n55,45,90,1\n56,91,0,1\n");
    folder_.write("drive.toml", R"(
[[lidar]]
name = "a"
packets = "lidar.pcap"
sender = "0.0.0.1"
T_vehicle_lidar = [1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1]
[[lidar]]
name = "b"
packets = "lidar.pcap"
sender = "0.0.0.2"
T_vehicle_lidar = [1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1]
[[lidar]]
name = "c"
sweeps = "sweeps"
T_vehicle_lidar = [1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1]
[[camera]]
name = "left"
images = "left"
width = 10
height = 10
fx = 10
fy = 10
cx = 5
cy = 5
lidar = "a"
T_camera_lidar = [1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1]
stamp_delay_ms = 1
[can]
log = "can.log"
dbc = "vehicle.dbc"
[imu]
file = "imu.csv"
delay_ms = 2e-6
[gnss]
file = "gnss.csv"
)");
  }

  // "stamp kind" of every event.
  std::vector<std::string> read() {
    const auto drive = Drive::open(folder_.path());
    if (!drive) return {drive.error().message()};
    auto source = DriveSource::open(*drive);
    if (!source) return {source.error().message()};
    std::vector<std::string> lines;
    DriveEvent event;
    while (source->next(event)) {
      lines.push_back(std::to_string(event.stamp.ns()) + " " +
                      std::visit(EventPrinter{}, event.content));
    }
    for (const Error& note : source->notes()) notes_ += note.message() + "\n";
    return lines;
  }

  struct EventPrinter {
    std::string operator()(const DatagramEvent& e) const {
      return (e.lidar == kNoLidar ? "stray" : "lidar " + std::to_string(e.lidar)) + " port " +
             std::to_string(e.datagram.destination_port);
    }
    std::string operator()(const SweepEvent& e) const {
      return "sweep " + std::to_string(e.lidar) + " number " + std::to_string(e.sweep->sequence) +
             " of " + std::to_string(e.sweep->size());
    }
    std::string operator()(const ImageEvent& e) const {
      return "image " + std::to_string(e.sequence) + " " + e.path->filename().string();
    }
    std::string operator()(const CanLineEvent& e) const { return "can " + std::string(e.line); }
    std::string operator()(const WheelOdometry& e) const {
      return "speed " + std::to_string(static_cast<int>(e.speed));
    }
    std::string operator()(const ImuSample& e) const {
      return "imu " + std::to_string(static_cast<int>(e.linear_acceleration[2]));
    }
    std::string operator()(const GnssFix& e) const {
      return "gps " + std::to_string(std::lround(e.longitude * 1e6));
    }
  };

  ScratchFolder folder_;
  std::string notes_;
};

TEST_F(WholeDrive, IsReadInStampOrder) {
  EXPECT_THAT(read(),
              ElementsAre("10 lidar 0 port 2368", "20 sweep 2 number 0 of 2",
                          "30 image 0 000000.png", "40 can (0.000000040) can0 123#00", "43 imu 6",
                          "50 can (0.000000050) can0 124#", "55 gps 1570796",
                          "60 lidar 1 port 2368", "66 image 1 000001.jpg", "70 lidar 1 port 8308",
                          "75 sweep 2 number 2 of 1", "80 stray port 2368", "90 stray port 9999"));
  EXPECT_THAT(notes_, HasSubstr("lidar.pcap, packet 6, byte "));
  EXPECT_THAT(notes_, HasSubstr("000001.bin: is 8 bytes long"));
  EXPECT_THAT(notes_, HasSubstr("can.log:2: does not begin with a time"));
  EXPECT_THAT(notes_, HasSubstr("2 such lines were skipped"));
  EXPECT_THAT(notes_, HasSubstr("imu.csv:3: "));
  EXPECT_THAT(notes_, HasSubstr("gnss.csv:3: "));
}

TEST_F(WholeDrive, ErrorsNameTheInvalidFile) {
  folder_.write("sweeps/times.csv", "stamp\n1\n");
  EXPECT_THAT(read(), ElementsAre(HasSubstr("sweeps/times.csv:1: has no column 'stamp_ns'")));
}

TEST(DriveSource, ReadsARealCaptureAsOneStream) {
  INFUSE_REAL_DATA_OR_SKIP(path, "velodyne/hdl32e-monterey.pcap");
  auto source = DriveSource::open_capture(path);
  ASSERT_TRUE(source);
  DriveEvent event;
  size_t events = 0;
  while (source->next(event)) {
    ++events;
    ASSERT_EQ(std::get<DatagramEvent>(event.content).lidar, 0u);
  }
  EXPECT_EQ(events, 2702u + 299u);
  EXPECT_TRUE(source->notes().empty());
}

}  // namespace
}  // namespace infuse::recording
