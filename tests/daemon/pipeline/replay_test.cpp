#include "daemon/pipeline/replay.hpp"

#include <gmock/gmock.h>

#include <cctype>
#include <random>
#include <thread>

#include "drivers/recording/pcap_reader.hpp"
#include "drivers/recording/pcap_writer.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"
#include "fixtures/scene/capture.hpp"
#include "tests/daemon/pipeline/run_replay.hpp"
#include "tests/daemon/schema.hpp"
#include "tests/daemon/socket_client.hpp"
#include "tests/real_data.hpp"

namespace infuse::daemon {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class ReplayTest : public testing::Test {
 protected:
  fixtures::CaptureTruth make(double seconds, double loss = 0,
                              velodyne::Model model = velodyne::Model::kVlp16) {
    fixtures::CaptureOptions options;
    options.model = &velodyne::lidar_model(model);
    options.duration = from_seconds(seconds);
    options.loss = loss;
    const auto truth = fixtures::make_capture(path_, options);
    EXPECT_TRUE(truth);
    return *truth;
  }

  /// Writes the capture without the datagrams of `leave_out` to another file.
  template <class LeaveOut>
  std::filesystem::path without(LeaveOut leave_out) {
    const auto path = folder_ / "without.pcap";
    auto reader = recording::PcapReader::open(path_);
    auto writer = recording::PcapWriter::create(path);
    Datagram datagram;
    std::optional<Stamp> start;
    while (reader->next(datagram)) {
      if (!start) start = datagram.stamp;
      if (!leave_out(to_seconds(datagram.stamp - *start), datagram)) {
        EXPECT_TRUE(writer->write(datagram));
      }
    }
    EXPECT_TRUE(writer->close());
    return path;
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "street.pcap";
};

TEST_F(ReplayTest, CountsEveryPacketAndReturnOfAGeneratedCapture) {
  const auto truth = make(3.05, 0, velodyne::Model::kHdl32e);
  const auto result = run_replay(path_);
  ASSERT_TRUE(result) << result.error().message();
  const LidarCounters& counters = result->totals.counters.lidars.at(0);
  EXPECT_EQ(counters.packets, truth.packets);
  EXPECT_EQ(counters.position_packets, truth.position_packets);
  EXPECT_EQ(counters.returns, truth.returns);
  EXPECT_EQ(counters.lost_network, 0U);
  EXPECT_EQ(counters.sweeps, 31U);  // cut at the rear: half a turn, then 30 turns, 3.05 s at 10 Hz
  EXPECT_EQ(result->sensors.at(0).device.model, "HDL-32E");
  EXPECT_EQ(result->totals.alerts, 0U);

  uint64_t returns = 0, sweeps = 0, healths = 0;
  for (const std::string& line : result->lines()) {
    ASSERT_TRUE(is_valid_message(line));
    const json report = json::parse(line);
    EXPECT_FALSE(report.contains("host"));
    if (report["class"] == "HEALTH") ++healths;
    if (report["class"] != "SWEEP") continue;
    EXPECT_EQ(report["sequence"], sweeps++);
    returns += report["returns"].get<uint64_t>();
  }
  EXPECT_EQ(returns, truth.returns);
  EXPECT_EQ(sweeps, counters.sweeps);
  EXPECT_EQ(healths, 4U);  // three whole seconds, and the end
}

TEST_F(ReplayTest, LostPacketsAreCountedAndReported) {
  const auto truth = make(8, 0.08);
  ASSERT_GT(truth.lost, 100U);
  const auto result = run_replay(path_);
  ASSERT_TRUE(result);
  const LidarCounters& counters = result->totals.counters.lidars.at(0);
  EXPECT_EQ(counters.packets, truth.packets);
  EXPECT_NEAR(static_cast<double>(counters.lost_network), static_cast<double>(truth.lost), 3);
  EXPECT_EQ(result->totals.levels.lidars.at(0), Level::kError);
  ASSERT_EQ(result->totals.first_alerts.size(), 1U);
  EXPECT_THAT(result->totals.first_alerts[0].finding.what, HasSubstr("in the network"));
}

TEST_F(ReplayTest, GivesTheSameBytesAtEveryRateAndWithASlowClient) {
  make(1.5, 0.01);
  const auto fastest = run_replay(path_);
  ASSERT_TRUE(fastest);
  ASSERT_GT(fastest->lines().size(), 15U);
  for (const double rate : {10.0, 1.0}) {
    const auto slower = run_replay(path_, {.rate = rate});
    ASSERT_TRUE(slower);
    EXPECT_EQ(slower->reports, fastest->reports) << rate;
  }
  std::thread slow([&] {
    for (int i = 0; i < 1000; ++i) {
      SocketClient client(folder_ / "s");
      if (!client.connected()) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        continue;
      }
      client.send("{\"op\":\"watch\"}\n");
      std::this_thread::sleep_for(std::chrono::milliseconds(300));  // and never reads
      break;
    }
  });
  const auto watched = run_replay(path_, {.rate = 10, .socket = folder_ / "s"});
  slow.join();
  ASSERT_TRUE(watched);
  EXPECT_EQ(watched->reports, fastest->reports);
}

TEST_F(ReplayTest, AClientReceivesEveryReportWithHostFigures) {
  make(2.2);
  std::vector<std::string> seen;
  std::thread watcher([&] {
    for (int i = 0; i < 2000; ++i) {
      SocketClient client(folder_ / "s");
      if (!client.connected()) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        continue;
      }
      client.send("{\"op\":\"watch\"}\n");
      while (const auto line = client.read_line()) seen.push_back(*line);
      break;
    }
  });
  const auto result = run_replay(path_, {.rate = 4, .socket = folder_ / "s"});
  watcher.join();
  ASSERT_TRUE(result);
  int sweeps = 0, healths = 0;
  for (const std::string& line : seen) {
    ASSERT_TRUE(is_valid_message(line));
    const json report = json::parse(line);
    sweeps += report["class"] == "SWEEP";
    if (report["class"] != "HEALTH") continue;
    ++healths;
    ASSERT_TRUE(report.contains("host"));
    EXPECT_EQ(report["host"]["stages"].size(), kStageNames.size());
  }
  EXPECT_GE(sweeps, 15);
  EXPECT_GE(healths, 2);
}

TEST_F(ReplayTest, SilenceRaisesAnAlertThatIsClearedWhenPacketsComeBack) {
  make(12);
  const auto path = without([](double s, const Datagram&) { return s > 2 && s < 8; });
  const auto result = run_replay(path);
  ASSERT_TRUE(result);
  std::vector<json> alerts;
  for (const std::string& line : result->lines()) {
    const json report = json::parse(line);
    if (report["class"] == "ALERT" && report["id"] == "lidar.silent") alerts.push_back(report);
  }
  ASSERT_EQ(alerts.size(), 2U);
  EXPECT_EQ(alerts[0]["state"], "raised");
  EXPECT_THAT(alerts[0]["what"].get<std::string>(), HasSubstr("no data on port 2368"));
  EXPECT_EQ(alerts[1]["state"], "cleared");
  EXPECT_EQ(alerts[1]["since"], alerts[0]["stamp"]);
}

TEST_F(ReplayTest, AStoppedReplayGivesTheFirstReports) {
  make(20);
  const auto whole = run_replay(path_);
  const auto part = run_replay(path_, {.rate = 1, .stop_after = std::chrono::milliseconds(300)});
  ASSERT_TRUE(whole && part);
  EXPECT_TRUE(part->totals.ended);
  const auto all = whole->lines();
  const auto some = part->lines();
  ASSERT_GT(some.size(), 4U);
  ASSERT_LT(some.size(), all.size() / 2);
  // The stop cuts the last sweep short, with its pose, and DEVICES and HEALTH come early.
  for (size_t i = 0; i + 4 < some.size(); ++i) EXPECT_EQ(some[i], all[i]);
}

TEST_F(ReplayTest, ATruncatedCaptureIsReadUpToItsEndAndNoted) {
  make(2);
  std::filesystem::resize_file(path_, std::filesystem::file_size(path_) / 2 + 7);
  const auto result = run_replay(path_);
  ASSERT_TRUE(result);
  EXPECT_NEAR(static_cast<double>(result->totals.counters.lidars.at(0).packets), 754, 20);
  EXPECT_FALSE(result->notes.empty());
}

TEST_F(ReplayTest, AnInputThatIsNotADriveIsAnErrorWithAReason) {
  const auto absent = run_replay(folder_ / "absent.pcap");
  ASSERT_FALSE(absent);
  EXPECT_THAT(absent.error().message(), HasSubstr("absent.pcap"));
  std::ofstream(folder_ / "text.pcap") << "this is no capture, but it is long enough to look into";
  EXPECT_FALSE(run_replay(folder_ / "text.pcap"));
  const auto empty_folder = folder_ / "drive";
  std::filesystem::create_directory(empty_folder);
  EXPECT_FALSE(run_replay(empty_folder));

  make(0.5);
  const auto positions =
      without([](double, const Datagram& d) { return d.payload.size() == 1206; });
  const auto none = run_replay(positions);
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().message(), HasSubstr("no lidar packets"));
  EXPECT_THAT(none.error().message(), HasSubstr("512 bytes from 192.168.1.201 to port 8308"));
}

TEST_F(ReplayTest, ManyDamagedCapturesEndWithAResultOrAReason) {
  make(0.05);
  std::ifstream stream(path_, std::ios::binary);
  const std::string good((std::istreambuf_iterator<char>(stream)), {});
  std::mt19937 random(5);
  const auto damaged = folder_ / "damaged.pcap";
  for (int i = 0; i < 150; ++i) {
    std::string bytes = good;
    for (auto edits = 1 + random() % 20; edits > 0; --edits) {
      bytes[random() % (edits % 2 == 0 ? bytes.size() : 2000)] = static_cast<char>(random());
    }
    std::ofstream(damaged, std::ios::binary) << bytes;
    const auto result = run_replay(damaged);
    if (result) {
      EXPECT_TRUE(result->totals.ended);
    } else {
      EXPECT_FALSE(result.error().what.empty());
    }
  }
}

struct RealCapture {
  const char* file;
  const char* model;
  uint64_t packets;
  uint64_t position_packets;
};

class RealReplay : public testing::TestWithParam<RealCapture> {};

// Packet counts are from an index of the captures.
TEST_P(RealReplay, CountsEveryPacket) {
  INFUSE_REAL_DATA_OR_SKIP(path, std::string("velodyne/") + GetParam().file);
  const auto result = run_replay(path);
  ASSERT_TRUE(result) << result.error().message();
  const LidarCounters& counters = result->totals.counters.lidars.at(0);
  EXPECT_EQ(result->sensors.at(0).device.model, GetParam().model);
  EXPECT_EQ(counters.packets, GetParam().packets);
  EXPECT_EQ(counters.position_packets, GetParam().position_packets);
  EXPECT_EQ(counters.lost_network, 0U);
  EXPECT_TRUE(result->notes.empty());
  for (const std::string& line : result->lines()) EXPECT_TRUE(is_valid_message(line));
  if (std::string(GetParam().file) == "hdl32e-monterey.pcap") {
    EXPECT_EQ(counters.returns, 872'800U);
  }
}

INSTANTIATE_TEST_SUITE_P(Captures, RealReplay,
                         testing::Values(RealCapture{"hdl32e-monterey.pcap", "HDL-32E", 2702, 299},
                                         RealCapture{"hdl32e-moving.pcap", "HDL-32E", 876, 100},
                                         RealCapture{"vlp16-gps.pcap", "VLP-16", 293, 57},
                                         RealCapture{"vlp16-dual-return.pcap", "VLP-16", 603, 0},
                                         RealCapture{"vlp32c-half-turn.pcap", "VLP-32C", 379, 0}),
                         [](const auto& capture) {
                           std::string name = capture.param.file;
                           std::erase_if(name, [](char c) { return std::isalnum(c) == 0; });
                           return name;
                         });

}  // namespace
}  // namespace infuse::daemon
