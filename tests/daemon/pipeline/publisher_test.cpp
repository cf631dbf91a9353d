#include "daemon/pipeline/publisher.hpp"

#include <gmock/gmock.h>

#include <boost/asio/io_context.hpp>
#include <nlohmann/json.hpp>

#include "tests/daemon/pipeline/run_replay.hpp"
#include "tests/daemon/schema.hpp"
#include "tests/stamp_at.hpp"

namespace infuse::daemon {
namespace {

using nlohmann::json;
using testing::ElementsAre;

/// A publisher of one lidar and one camera.
class PublisherTest : public testing::Test {
 protected:
  static SensorSetup make_setup() {
    SensorSetup setup;
    setup.lidars.push_back(
        {.device = {"top", "lidar", "HDL-32E", "configured", "port 2368", std::nullopt}});
    setup.cameras.push_back(
        {.device = {"front", "camera", "pinhole", "configured", "front", std::nullopt}});
    return setup;
  }
  static ReportItem make_item() {
    ReportItem item;
    item.counters = SensorCounters(make_setup());
    return item;
  }

  void push(const ReportItem& item) {
    ring_.slot() = item;
    ring_.publish();
    EXPECT_FALSE(publisher_.drain());
  }

  void push_start() {
    ReportItem item = make_item();
    item.stamp = at(0);
    push(item);
  }

  void push_tick(double seconds, uint64_t packets) {
    ReportItem item = make_item();
    item.kind = ReportItem::Kind::kTick;
    item.stamp = at(seconds);
    item.counters.lidars[0].packets = item.counters.lidars[0].sweeps = packets;
    item.counters.lidars[0].first_packet = item.counters.lidars[0].last_packet = at(0.5);
    push(item);
  }

  /// The lines of the reports file so far, each validated.
  std::vector<json> lines() {
    EXPECT_TRUE(file_->close());
    std::vector<json> lines;
    std::ifstream stream(folder_ / "reports");
    for (std::string line; std::getline(stream, line);) {
      EXPECT_TRUE(is_valid_message(line));
      lines.push_back(json::parse(line));
    }
    return lines;
  }

  std::vector<std::string> classes() {
    std::vector<std::string> classes;
    for (const json& line : lines()) classes.push_back(line["class"]);
    return classes;
  }

  TemporaryFolder folder_;
  boost::asio::io_context io_;
  Server server_{io_, {}, "0", "0123456789abcdef"};
  Result<ReportsFile> file_ = ReportsFile::create(folder_ / "reports");
  SlotRing<ReportItem> ring_{8, make_item};
  SensorSetup setup_ = make_setup();
  Publisher publisher_{ring_, setup_, HealthOptions(), server_, &*file_};
};

TEST_F(PublisherTest, PublishesDevicesAtTheStartAndOnTheFirstPacket) {
  push_start();
  push_tick(0.5, 0);
  push_tick(1, 7);
  push_tick(1.5, 14);
  EXPECT_THAT(classes(), ElementsAre("DEVICES", "HEALTH", "DEVICES", "HEALTH", "HEALTH"));
  const json devices = lines()[2]["devices"];
  EXPECT_EQ(devices[0]["activated"], at(0.5).ns());
  EXPECT_FALSE(devices[1].contains("activated"));
}

TEST_F(PublisherTest, HealthHasHostFiguresForListenersOnly) {
  std::vector<HealthReport> heard;
  publisher_.add_health_listener([&](const HealthReport& health) { heard.push_back(health); });
  push_start();
  push_tick(1, 7);
  ASSERT_EQ(heard.size(), 1U);
  ASSERT_TRUE(heard[0].host);
  EXPECT_EQ(heard[0].host->stages.size(), kStageNames.size());
  EXPECT_EQ(heard[0].sensors.at(0).device, "top");
  EXPECT_EQ(heard[0].streams.at(0).kind, "camera");
  EXPECT_FALSE(heard[0].odometry);
  EXPECT_FALSE(lines().back().contains("host"));
}

TEST_F(PublisherTest, SilenceRaisesAnAlertBeforeTheHealthThatShowsIt) {
  std::vector<std::string> ids;
  publisher_.add_alert_listener([&](const AlertReport& alert) { ids.push_back(alert.id()); });
  push_start();
  for (int second = 1; second <= 4; ++second) push_tick(second, 7);
  EXPECT_THAT(ids, testing::UnorderedElementsAre("top.silent", "front.silent"));
  EXPECT_EQ(publisher_.totals().alerts, 2U);
  EXPECT_EQ(publisher_.totals().levels.lidars.at(0), Level::kStale);
  const auto published = lines();
  EXPECT_EQ(published.back()["class"], "HEALTH");
  EXPECT_EQ(published.back()["level"], "STALE");
  EXPECT_EQ(published[published.size() - 2]["class"], "ALERT");
}

TEST_F(PublisherTest, AConfirmedDriftRaisesAnAlertWithItsAxisAndSize) {
  push_start();
  ReportItem item = make_item();
  item.kind = ReportItem::Kind::kCalibration;
  item.calibration.camera = "front";
  item.calibration.stamp = at(1);
  item.calibration.state = monitoring::CalibrationState::kConfirmed;
  item.calibration.verdict.axis = monitoring::Axis::kRotationY;
  item.calibration.verdict.evidence = 20;
  item.calibration.verdict.threshold = 17;
  item.calibration.verdict.offset[1] = 0.01;
  push(item);
  const json alert = lines().back();
  EXPECT_EQ(alert["id"], "front.drift_confirmed");
  EXPECT_EQ(
      alert["what"],
      "calibration drift confirmed: rotation about y by +0.57 ± 0.00° (evidence 20.0, threshold "
      "17.0 nats)");
  EXPECT_EQ(publisher_.totals().calibrations.at("front").camera, "front");
  push_tick(2, 7);
  const json health = lines().back();
  EXPECT_EQ(health["level"], "ERROR");
  EXPECT_EQ(health["calibrations"][0]["device"], "front");
  EXPECT_EQ(health["calibrations"][0]["findings"][0]["what"], alert["what"]);
}

TEST_F(PublisherTest, ReportsOfOneKindAreKeptByDevice) {
  push_start();
  ReportItem item = make_item();
  item.kind = ReportItem::Kind::kPose;
  item.pose.stamp = at(1);
  push(item);
  item.kind = ReportItem::Kind::kSweep;
  item.sweep.device = "top";
  push(item);
  item.kind = ReportItem::Kind::kFrame;
  item.frame.device = "front";
  push(item);
  item.kind = ReportItem::Kind::kEnd;
  push(item);
  EXPECT_THAT(classes(), ElementsAre("DEVICES", "POSE", "SWEEP", "FRAME"));
  EXPECT_TRUE(publisher_.totals().ended);
}

}  // namespace
}  // namespace infuse::daemon
